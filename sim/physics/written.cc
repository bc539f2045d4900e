#include <mujoco/mjxmacro.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <span>
#include <sstream>

#include "sim/physics/compiled.h"

#undef MJ_M
#define MJ_M(size) m_.size

namespace sim::physics {
namespace {

using model_file::Element, model_file::text_of;

constexpr std::array kJoints{"free", "ball", "slide", "hinge"};  // as mjtJoint
constexpr std::array kGeoms{"plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"};

// Attributes and the model's arrays.
constexpr const char* kInertial = "mass=body_mass pos=body_ipos quat=body_iquat diaginertia=body_inertia";
constexpr const char* kJoint =
    "pos=jnt_pos axis=jnt_axis limited=jnt_limited range=jnt_range margin=jnt_margin stiffness=jnt_stiffness "
    "solreflimit=jnt_solref solimplimit=jnt_solimp";
constexpr const char* kDof =
    "armature=dof_armature damping=dof_damping frictionloss=dof_frictionloss solreffriction=dof_solref "
    "solimpfriction=dof_solimp";
constexpr const char* kGeom =
    "size=geom_size contype=geom_contype conaffinity=geom_conaffinity condim=geom_condim group=geom_group "
    "priority=geom_priority friction=geom_friction solmix=geom_solmix solref=geom_solref solimp=geom_solimp "
    "margin=geom_margin gap=geom_gap rgba=geom_rgba";
constexpr const char* kLight =
    "directional=light_directional castshadow=light_castshadow active=light_active pos=light_pos "
    "dir=light_dir "
    "attenuation=light_attenuation cutoff=light_cutoff exponent=light_exponent ambient=light_ambient "
    "diffuse=light_diffuse specular=light_specular";
constexpr const char* kMaterial =
    "texuniform=mat_texuniform texrepeat=mat_texrepeat rgba=mat_rgba emission=mat_emission "
    "specular=mat_specular shininess=mat_shininess reflectance=mat_reflectance";
constexpr const char* kTendon =
    "limited=tendon_limited range=tendon_range solreflimit=tendon_solref_lim solimplimit=tendon_solimp_lim "
    "solreffriction=tendon_solref_fri solimpfriction=tendon_solimp_fri margin=tendon_margin "
    "stiffness=tendon_stiffness damping=tendon_damping frictionloss=tendon_frictionloss "
    "springlength=tendon_lengthspring";
constexpr const char* kEquality = "active=eq_active solref=eq_solref solimp=eq_solimp";

template <class Number>
std::string text(const Number* numbers, int count) {
  if constexpr (std::is_same_v<Number, mjtByte>) return *numbers ? "true" : "false";
  return text_of(std::span(numbers, std::size_t(count)));
}

}  // namespace

Writer::Writer(const mjModel& model, const model_file::ModelFile& file, std::string prefix)
    : m_(model), file_(file), prefix_(std::move(prefix)) {
#define X(type, array, rows, columns) \
  texts_[#array] = [this](int id) { return text(m_.array + (columns)*id, columns); };
  MJMODEL_POINTERS
#undef X
  for (int geom = 0; geom < m_.ngeom; ++geom)
    if (name(mjOBJ_BODY, m_.geom_bodyid[geom]) == model_file::kMeshes)
      meshes_[m_.geom_dataid[geom]] = turned_pose_in(m_.geom_pos + 3 * geom, m_.geom_quat + 4 * geom);
}

std::string Writer::name(int type, int id) const { return name_of(m_, type, id); }

// The bench has its own sites.
std::string Writer::site_name(int site) const {
  const std::string own = name(mjOBJ_SITE, site);
  return "site/" + (own.empty() ? std::to_string(site) : own);
}

bool Writer::is_fused(int body) const {
  return (m_.body_mass[body] == 0 || m_.body_weldid[body] == 0) &&
         name(mjOBJ_BODY, body).starts_with(model_file::kFrame);
}

int Writer::owner(int body) const {
  while (is_fused(body)) body = m_.body_parentid[body];
  return body;
}

void Writer::add(Element& element, const char* attributes, int id) const {
  std::istringstream words(attributes);
  for (std::string word; words >> word;) {
    const std::size_t equals = word.find('=');
    element.set(word.substr(0, equals), texts_.at(word.substr(equals + 1))(id));
  }
}

Element Writer::part(const char* kind, int type, int id, const char* attributes) const {
  Element made{kind};
  if (const std::string own = name(type, id); !own.empty()) made.set("name", own);
  add(made, attributes, id);
  return made;
}

void Writer::place(Element& element, const mjtNum* p, const mjtNum* q, const Eigen::Isometry3d* X) const {
  element.set("pos", text_of(std::span(p, 3)));
  element.set("quat", text_of(std::span(q, 4)));
  if (!X) return;
  const Eigen::Isometry3d placed = *X * turned_pose_in(p, q);
  const Eigen::Quaterniond turn(placed.linear());
  element.set("pos", text_of(placed.translation()));
  element.set("quat", text_of(std::array{turn.w(), turn.x(), turn.y(), turn.z()}));
}

Element Writer::body(int body, const Eigen::Isometry3d* X) const {
  Element made = part("body", mjOBJ_BODY, body, "pos=body_pos quat=body_quat");
  place(made, m_.body_pos + 3 * body, m_.body_quat + 4 * body, X);
  if (m_.body_weldid[body] != 0) add(made.add("inertial"), kInertial, body);
  for (int k = 0; k < m_.body_jntnum[body]; ++k)
    if (const int joint = m_.body_jntadr[body] + k; !rigid.contains(joint))
      made.children.push_back(this->joint(joint));
  add_content(body, made);
  return made;
}

void Writer::add_content(int body, Element& to, const Eigen::Isometry3d* X) const {
  for (int geom = 0; geom < m_.ngeom; ++geom)
    if (m_.geom_bodyid[geom] == body) to.children.push_back(this->geom(geom, X));
  for (int site = 0; site < m_.nsite; ++site)
    if (m_.site_bodyid[site] == body)
      place(to.add("site", {{"name", site_name(site)}}), m_.site_pos + 3 * site, m_.site_quat + 4 * site, X);
  for (int light = 0; light < m_.nlight; ++light)
    if (m_.light_bodyid[light] == body) add(to.add("light"), kLight, light);
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
  const int type = m_.jnt_type[joint];
  Element made = part("joint", mjOBJ_JOINT, joint, kJoint);
  made.set("type", kJoints[std::size_t(type)]);
  add(made, kDof, m_.jnt_dofadr[joint]);
  if (type != mjJNT_BALL) add(made, "ref=qpos0 springref=qpos_spring", m_.jnt_qposadr[joint]);
  return made;
}

Element Writer::geom(int geom, const Eigen::Isometry3d* X) const {
  const int type = m_.geom_type[geom], data = m_.geom_dataid[geom], material = m_.geom_matid[geom];
  Element made = part("geom", mjOBJ_GEOM, geom, kGeom);
  made.set("type", kGeoms[std::size_t(type)]);
  Eigen::Isometry3d moved = X ? *X : Eigen::Isometry3d::Identity();
  if (type == mjGEOM_MESH) {  // as in the mesh's file
    made.set("mesh", prefix_ + name(mjOBJ_MESH, data));
    const Eigen::Isometry3d placed = turned_pose_in(m_.geom_pos + 3 * geom, m_.geom_quat + 4 * geom);
    moved = moved * placed * meshes_.at(data).inverse() * placed.inverse(), X = &moved;
  }
  place(made, m_.geom_pos + 3 * geom, m_.geom_quat + 4 * geom, X);
  if (type == mjGEOM_HFIELD) made.set("hfield", prefix_ + name(mjOBJ_HFIELD, data));
  if (material >= 0) made.set("material", prefix_ + name(mjOBJ_MATERIAL, material));
  return made;
}

Element Writer::material(int material) const {
  Element made = part("material", mjOBJ_MATERIAL, material, kMaterial);
  made.set("name", prefix_ + made.get("name"));
  if (const int texture = m_.mat_texid[material]; texture >= 0)
    made.set("texture", prefix_ + name(mjOBJ_TEXTURE, texture));
  return made;
}

Element Writer::tendon(int tendon) const {
  const int first = m_.tendon_adr[tendon];
  const bool is_fixed = m_.wrap_type[first] == mjWRAP_JOINT;
  Element made = part(is_fixed ? "fixed" : "spatial", mjOBJ_TENDON, tendon, kTendon);
  for (int wrap = first; wrap < first + m_.tendon_num[tendon]; ++wrap) {
    const int object = m_.wrap_objid[wrap], type = m_.wrap_type[wrap];
    const std::string number = text_of(std::span(m_.wrap_prm + wrap, 1));
    if (type == mjWRAP_JOINT)
      made.add("joint", {{"joint", name(mjOBJ_JOINT, object)}, {"coef", number}});
    else if (type == mjWRAP_PULLEY)
      made.add("pulley", {{"divisor", number}});
    else if (type == mjWRAP_SITE)
      made.add("site", {{"site", site_name(object)}});
    else if (Element& geom = made.add("geom", {{"geom", name(mjOBJ_GEOM, object)}}); m_.wrap_prm[wrap] >= 0)
      geom.set("sidesite", site_name(int(m_.wrap_prm[wrap])));
  }
  return made;
}

void Writer::add_sections(Element& root) const {
  Element assets{"asset"}, tendons{"tendon"}, equalities{"equality"};
  for (Element asset : file_.assets) {
    asset.set("name", prefix_ + asset.get("name"));
    assets.children.push_back(std::move(asset));
  }
  for (int id = 0; id < m_.nmat; ++id) assets.children.push_back(material(id));
  std::set<int> without;  // tendons
  for (int id = 0; id < m_.ntendon; ++id) {
    for (int wrap = m_.tendon_adr[id]; wrap < m_.tendon_adr[id] + m_.tendon_num[id]; ++wrap)
      if (m_.wrap_type[wrap] == mjWRAP_JOINT && rigid.contains(m_.wrap_objid[wrap])) without.insert(id);
    if (!without.contains(id)) tendons.children.push_back(tendon(id));
  }
  for (int id = 0; id < m_.neq; ++id) {
    const bool joints = m_.eq_type[id] == mjEQ_JOINT;
    Element made{joints ? "joint" : "tendon"};
    bool whole = true;
    for (const auto& [end, number] : {std::pair(m_.eq_obj1id[id], "1"), {m_.eq_obj2id[id], "2"}}) {
      whole &= !(joints ? rigid : without).contains(end);
      if (end >= 0) made.set(made.name + number, name(joints ? mjOBJ_JOINT : mjOBJ_TENDON, end));
    }
    made.set("polycoef", text_of(std::span(m_.eq_data + mjNEQDATA * id, 5)));
    add(made, kEquality, id);
    if (whole) equalities.children.push_back(std::move(made));
  }
  for (Element* const section : {&assets, &tendons, &equalities})
    if (!section->children.empty()) root.children.push_back(std::move(*section));
}

}  // namespace sim::physics
