#include "sim/physics/written.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <span>

namespace sim::physics {
namespace {

using model_file::Element;

constexpr std::array kJoints{"free", "ball", "slide", "hinge"};  // as mjtJoint
constexpr std::array kGeoms{"plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"};

/// An element with numbers from the model's arrays.
struct Row {
  Element element;
  int id;

  void add(const char* attribute, const auto* all, int count = 1) {
    element.set(attribute, model_file::text_of(std::span(all + count * id, std::size_t(count))));
  }
  void add_flag(const char* attribute, bool value) { element.set(attribute, value ? "true" : "false"); }
};

}  // namespace

Writer::Writer(const mjModel& model, const model_file::ModelFile& file, std::string prefix)
    : m_(model), file_(file), prefix_(std::move(prefix)) {
  for (int geom = 0; geom < m_.ngeom; ++geom)
    if (name(mjOBJ_BODY, m_.geom_bodyid[geom]) == model_file::kMeshes)
      meshes_[m_.geom_dataid[geom]] = turned_pose_in(m_.geom_pos + 3 * geom, m_.geom_quat + 4 * geom);
}

std::string Writer::name(int type, int id) const {
  const char* const own = mj_id2name(&m_, type, id);
  return own ? own : "";
}

bool Writer::is_fused(int body) const {
  return m_.body_mass[body] == 0 && name(mjOBJ_BODY, body).starts_with(model_file::kFrame);
}

int Writer::owner(int body) const {
  while (is_fused(body)) body = m_.body_parentid[body];
  return body;
}

void Writer::place(Element& element, const mjtNum* p, const mjtNum* q, const Eigen::Isometry3d* X) const {
  if (!X) {
    element.set("pos", model_file::text_of(std::span(p, 3)));
    return element.set("quat", model_file::text_of(std::span(q, 4)));
  }
  const Eigen::Isometry3d placed = *X * turned_pose_in(p, q);
  const Eigen::Quaterniond turn(placed.linear());
  element.set("pos", model_file::text_of(placed.translation()));
  element.set("quat", model_file::text_of(std::array{turn.w(), turn.x(), turn.y(), turn.z()}));
}

void Writer::require_finite(const Element& written) const {
  for (const auto& [attribute, text] : written.attributes)
    if (attribute != "name" && (text.find("nan") != text.npos || text.find("inf") != text.npos))
      reject(file_.named(written.name, written.get("name")), attribute, "is not finite, expected a number");
}

Element Writer::body(int body, const Eigen::Isometry3d* X) const {
  Element made{"body"};
  if (const std::string own = name(mjOBJ_BODY, body); !own.empty()) made.set("name", own);
  place(made, m_.body_pos + 3 * body, m_.body_quat + 4 * body, X);
  require_finite(made);
  Row inertial{{"inertial"}, body};
  inertial.add("mass", m_.body_mass);
  inertial.add("pos", m_.body_ipos, 3);
  inertial.add("quat", m_.body_iquat, 4);
  inertial.add("diaginertia", m_.body_inertia, 3);
  if (m_.body_weldid[body] != 0) made.children.push_back(inertial.element);
  for (int k = 0; k < m_.body_jntnum[body]; ++k)
    if (const int joint = m_.body_jntadr[body] + k; !rigid.contains(joint))
      made.children.push_back(this->joint(joint));
  add_content(body, made);
  return made;
}

void Writer::add_content(int body, Element& to, const Eigen::Isometry3d* X) const {
  for (int geom = 0; geom < m_.ngeom; ++geom)
    if (m_.geom_bodyid[geom] == body) require_finite(to.children.emplace_back(this->geom(geom, X)));
  for (int site = 0; site < m_.nsite; ++site)
    if (m_.site_bodyid[site] == body && m_.ntendon > 0) {
      Element& made = to.add("site", {{"name", fmt::format("site/{}", site)}});
      place(made, m_.site_pos + 3 * site, m_.site_quat + 4 * site, X);
    }
  for (int light = 0; light < m_.nlight; ++light) {
    if (m_.light_bodyid[light] != body) continue;
    Row row{{"light"}, light};
    row.add_flag("directional", m_.light_directional[light]);
    row.add_flag("castshadow", m_.light_castshadow[light]);
    row.add_flag("active", m_.light_active[light]);
    for (const auto& [attribute, numbers] : {std::pair("pos", m_.light_pos), {"dir", m_.light_dir}})
      row.add(attribute, numbers, 3);
    for (const auto& [attribute, numbers] : {std::pair("attenuation", m_.light_attenuation),
                                             {"ambient", m_.light_ambient},
                                             {"diffuse", m_.light_diffuse},
                                             {"specular", m_.light_specular}})
      row.add(attribute, numbers, 3);
    row.add("cutoff", m_.light_cutoff);
    row.add("exponent", m_.light_exponent);
    to.children.push_back(row.element);
  }
  if (const auto added = additions.find(body); added != additions.end())
    std::ranges::copy(added->second, std::back_inserter(to.children));
  for (int child = 1; child < m_.nbody; ++child) {
    if (m_.body_parentid[child] != body || name(mjOBJ_BODY, child) == model_file::kMeshes) continue;
    if (!is_fused(child)) {
      to.children.push_back(this->body(child, X));
      continue;
    }
    Eigen::Isometry3d inside = turned_pose_in(m_.body_pos + 3 * child, m_.body_quat + 4 * child);
    if (X) inside = *X * inside;
    add_content(child, to, &inside);
  }
}

Element Writer::joint(int joint) const {
  const int type = m_.jnt_type[joint], dof = m_.jnt_dofadr[joint], q = m_.jnt_qposadr[joint];
  Row row{{type == mjJNT_FREE ? "freejoint" : "joint"}, joint};
  if (const std::string own = name(mjOBJ_JOINT, joint); !own.empty()) row.element.set("name", own);
  if (type == mjJNT_FREE) return row.element;
  row.element.set("type", kJoints[std::size_t(type)]);
  row.add("pos", m_.jnt_pos, 3);
  row.add("axis", m_.jnt_axis, 3);
  row.add_flag("limited", m_.jnt_limited[joint]);
  if (m_.jnt_limited[joint]) row.add("range", m_.jnt_range, 2);
  row.add("margin", m_.jnt_margin);
  row.add("stiffness", m_.jnt_stiffness);
  row.add("solreflimit", m_.jnt_solref, mjNREF);
  row.add("solimplimit", m_.jnt_solimp, mjNIMP);
  row.id = dof;
  row.add("armature", m_.dof_armature);
  row.add("damping", m_.dof_damping);
  row.add("frictionloss", m_.dof_frictionloss);
  row.add("solreffriction", m_.dof_solref, mjNREF);
  row.add("solimpfriction", m_.dof_solimp, mjNIMP);
  row.id = q;
  if (type != mjJNT_BALL) row.add("ref", m_.qpos0), row.add("springref", m_.qpos_spring);
  return row.element;
}

Element Writer::geom(int geom, const Eigen::Isometry3d* X) const {
  const int type = m_.geom_type[geom], data = m_.geom_dataid[geom], material = m_.geom_matid[geom];
  Row row{{"geom"}, geom};
  if (const std::string own = name(mjOBJ_GEOM, geom); !own.empty()) row.element.set("name", own);
  row.element.set("type", kGeoms[std::size_t(type)]);
  if (type == mjGEOM_MESH) {  // as in the mesh's file
    const Eigen::Isometry3d unmoved =
        turned_pose_in(m_.geom_pos + 3 * geom, m_.geom_quat + 4 * geom) * meshes_.at(data).inverse();
    const Eigen::Quaterniond turn(unmoved.linear());
    const std::array q{turn.w(), turn.x(), turn.y(), turn.z()};
    place(row.element, unmoved.translation().data(), q.data(), X);
    row.element.set("mesh", prefix_ + name(mjOBJ_MESH, data));
  } else {
    place(row.element, m_.geom_pos + 3 * geom, m_.geom_quat + 4 * geom, X);
    type == mjGEOM_HFIELD ? row.element.set("hfield", prefix_ + name(mjOBJ_HFIELD, data))
                          : row.add("size", m_.geom_size, 3);
  }
  for (const auto& [attribute, numbers] : {std::pair("contype", m_.geom_contype),
                                           {"conaffinity", m_.geom_conaffinity},
                                           {"condim", m_.geom_condim},
                                           {"group", m_.geom_group},
                                           {"priority", m_.geom_priority}})
    row.add(attribute, numbers);
  row.add("friction", m_.geom_friction, 3);
  row.add("solmix", m_.geom_solmix);
  row.add("solref", m_.geom_solref, mjNREF);
  row.add("solimp", m_.geom_solimp, mjNIMP);
  row.add("margin", m_.geom_margin);
  row.add("gap", m_.geom_gap);
  row.add("rgba", m_.geom_rgba, 4);
  if (material >= 0) row.element.set("material", prefix_ + name(mjOBJ_MATERIAL, material));
  return row.element;
}

Element Writer::material(int material) const {
  Row row{{"material", {{"name", prefix_ + name(mjOBJ_MATERIAL, material)}}}, material};
  if (const int texture = m_.mat_texid[material]; texture >= 0)
    row.element.set("texture", prefix_ + name(mjOBJ_TEXTURE, texture));
  row.add_flag("texuniform", m_.mat_texuniform[material]);
  row.add("texrepeat", m_.mat_texrepeat, 2);
  row.add("rgba", m_.mat_rgba, 4);
  for (const auto& [attribute, numbers] : {std::pair("emission", m_.mat_emission),
                                           {"specular", m_.mat_specular},
                                           {"shininess", m_.mat_shininess},
                                           {"reflectance", m_.mat_reflectance}})
    row.add(attribute, numbers);
  return row.element;
}

Element Writer::tendon(int tendon) const {
  const int first = m_.tendon_adr[tendon], end = first + m_.tendon_num[tendon];
  const bool is_fixed = m_.wrap_type[first] == mjWRAP_JOINT;
  Row row{{is_fixed ? "fixed" : "spatial"}, tendon};
  if (const std::string own = name(mjOBJ_TENDON, tendon); !own.empty()) row.element.set("name", own);
  row.add_flag("limited", m_.tendon_limited[tendon]);
  if (m_.tendon_limited[tendon]) row.add("range", m_.tendon_range, 2);
  row.add("solreflimit", m_.tendon_solref_lim, mjNREF);
  row.add("solimplimit", m_.tendon_solimp_lim, mjNIMP);
  row.add("solreffriction", m_.tendon_solref_fri, mjNREF);
  row.add("solimpfriction", m_.tendon_solimp_fri, mjNIMP);
  for (const auto& [attribute, numbers] : {std::pair("margin", m_.tendon_margin),
                                           {"stiffness", m_.tendon_stiffness},
                                           {"damping", m_.tendon_damping},
                                           {"frictionloss", m_.tendon_frictionloss},
                                           {"springlength", m_.tendon_lengthspring}})
    row.add(attribute, numbers);
  for (int wrap = first; wrap < end; ++wrap) {
    const int object = m_.wrap_objid[wrap], type = m_.wrap_type[wrap];
    const double number = m_.wrap_prm[wrap];
    if (type == mjWRAP_JOINT)
      row.element.add(
          "joint", {{"joint", name(mjOBJ_JOINT, object)}, {"coef", model_file::text_of(std::array{number})}});
    else if (type == mjWRAP_PULLEY)
      row.element.add("pulley", {{"divisor", model_file::text_of(std::array{number})}});
    else if (type == mjWRAP_SITE)
      row.element.add("site", {{"site", fmt::format("site/{}", object)}});
    else if (Element& geom = row.element.add("geom", {{"geom", name(mjOBJ_GEOM, object)}}); number >= 0)
      geom.set("sidesite", fmt::format("site/{}", int(number)));
  }
  return row.element;
}

void Writer::add_sections(Element& root) const {
  Element assets{"asset"}, tendons{"tendon"}, equalities{"equality"};
  for (Element asset : file_.assets) {
    asset.set("name", prefix_ + asset.get("name"));
    assets.children.push_back(std::move(asset));
  }
  for (int id = 0; id < m_.nmat; ++id) assets.children.push_back(material(id));
  const auto left_out = [this](int type, int id) { return type == mjWRAP_JOINT && rigid.contains(id); };
  std::set<int> without;  // tendons
  for (int id = 0; id < m_.ntendon; ++id) {
    for (int wrap = m_.tendon_adr[id]; wrap < m_.tendon_adr[id] + m_.tendon_num[id]; ++wrap)
      if (left_out(m_.wrap_type[wrap], m_.wrap_objid[wrap])) without.insert(id);
    if (!without.contains(id)) tendons.children.push_back(tendon(id));
  }
  for (int id = 0; id < m_.neq; ++id) {
    const bool joints = m_.eq_type[id] == mjEQ_JOINT;
    const int type = joints ? mjOBJ_JOINT : mjOBJ_TENDON, ends[]{m_.eq_obj1id[id], m_.eq_obj2id[id]};
    Row row{{joints ? "joint" : "tendon"}, id};
    bool whole = true;
    for (int i = 0; i < 2; ++i) {
      if (ends[i] < 0) continue;
      whole &= !(joints ? rigid : without).contains(ends[i]);
      row.element.set(fmt::format("{}{}", row.element.name, i + 1), name(type, ends[i]));
    }
    row.element.set("polycoef", model_file::text_of(std::span(m_.eq_data + mjNEQDATA * id, 5)));
    row.add_flag("active", m_.eq_active[id]);
    row.add("solref", m_.eq_solref, mjNREF);
    row.add("solimp", m_.eq_solimp, mjNIMP);
    if (whole) equalities.children.push_back(row.element);
  }
  for (Element* const section : {&assets, &tendons, &equalities})
    if (!section->children.empty()) root.children.push_back(std::move(*section));
}

}  // namespace sim::physics
