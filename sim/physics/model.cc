#include "sim/physics/model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "sim/model_file/element.h"
#include "sim/physics/actors.h"

namespace sim::physics {
namespace {

using model_file::Element;

constexpr const char* kError = "Error: ";

/// Returns the element that to_xml() writes on a line, or nullptr. `line` counts down to 0.
const Element* written_at(const Element& element, int& line) {
  if (--line == 0) return &element;
  for (const Element& child : element.children)
    if (const Element* const found = written_at(child, line)) return found;
  line -= element.children.empty() ? 0 : 1;
  return line == 0 ? &element : nullptr;
}

/// Throws the library's error, which names the object or the line on which to_xml() writes the element.
[[noreturn]] void reject_as_library(const Element& root, const std::string& from, std::string message) {
  constexpr std::string_view kNames = "Object name = ";
  const std::size_t end = message.find('\n'), at = message.rfind("line "), named = message.find(kNames);
  int line = at == message.npos ? 0 : std::atoi(message.c_str() + message.find_first_of("0123456789", at));
  const Element* element = line > 0 ? written_at(root, line) : nullptr;
  if (!element && named != message.npos) {
    const std::size_t from_name = named + kNames.size();
    const std::string name = message.substr(from_name, message.find(',', from_name) - from_name);
    root.visit([&](const Element& each) {
      if (!element && each.get("name") == name) element = &each;
    });
  }
  message.erase(std::min(end, message.size()));
  if (const std::size_t error = message.find(kError); error != message.npos)
    message.erase(0, error + std::strlen(kError));
  if (element && element->line > 0) model_file::reject(*element, "", "{}", message);
  throw std::runtime_error(fmt::format("{} does not load: {}", from, message));
}

/// Adds a file to MuJoCo's virtual ones.
void add_file(mjVFS& files, const std::string& name, const std::string& text) {
  mj_makeEmptyFileVFS(&files, name.c_str(), int(text.size()));
  std::memcpy(files.filedata[files.nfile - 1], text.data(), text.size());
}

thread_local std::array<char, 1000> last_warning{};  // MuJoCo calls back on the thread that steps

}  // namespace

void Free::operator()(mjModel_* model) const { mj_deleteModel(model); }
void Free::operator()(mjData_* data) const { mj_deleteData(data); }

Model load_mjcf(const model_file::Element& root, const std::string& from, const NamedFiles& named) {
  // MuJoCo's own handler waits for a key. Throwing through its C frames is not safe, so the process ends.
  mju_user_error = [](const char* message) {
    std::fprintf(stderr, "gaitslam: MuJoCo: %s\n", message);
    std::fflush(nullptr);
    _exit(3);
  };
  mju_user_warning = [](const char* message) {
    std::snprintf(last_warning.data(), last_warning.size(), "%s", message);
  };
  const std::unique_ptr<mjVFS, void (*)(mjVFS*)> files(new mjVFS, [](mjVFS* vfs) {
    mj_deleteVFS(vfs);
    delete vfs;
  });
  mj_defaultVFS(files.get());
  add_file(*files, "model.xml", to_xml(root));
  for (const auto& [name, file] : named) add_file(*files, name, files::read_text(file));
  std::array<char, 1000> message{};
  Model model(mj_loadXML("model.xml", files.get(), message.data(), int(message.size())));
  if (!model) reject_as_library(root, from, message.data());
  return model;
}

namespace {

constexpr double kEndless = 1e6;  // m, half the size of a plane without a size

void set_pose(mjtNum* position, mjtNum* quaternion, const Eigen::Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  Eigen::Map<Eigen::Vector3d>(position, 3) = X.translation();
  Eigen::Map<Eigen::Vector4d>(quaternion, 4) << q.w(), q.vec();
}

// The axes forward, left, up in a MuJoCo camera's axes: x right, y up, looking along -z.
Eigen::Isometry3d camera_from_place() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() << 0, -1, 0, 0, 0, 1, -1, 0, 0;
  return X;
}

/// Returns the first body of the leg that ends in this sole: a child of the base.
int leg_root(const mjModel& model, const char* sole) {
  int body = model.site_bodyid[part(model, mjOBJ_SITE, sole)];
  while (model.body_parentid[body] != model.jnt_bodyid[0]) body = model.body_parentid[body];
  return body;
}

// Throws if there is a leg joint between the body and the waist.
int upper_link(const mjModel& model, const std::string& link) {
  const std::array legs{leg_root(model, "left_sole"), leg_root(model, "right_sole")};
  std::vector<std::string> links;
  std::vector<bool> in_leg(std::size_t(model.nbody));  // parents come first
  for (int body = 1; body < model.nbody; ++body) {
    const auto i = std::size_t(body), parent = std::size_t(model.body_parentid[body]);
    in_leg[i] = in_leg[parent] || std::ranges::find(legs, body) != legs.end();
    if (model.body_weldid[body] == 0 || in_leg[i]) continue;
    links.push_back(name_of(model, mjOBJ_BODY, body));
    if (links.back() == link) return body;
  }
  throw std::invalid_argument(
      fmt::format("link '{}' is not an upper-body link, expected one of {}", link, fmt::join(links, ", ")));
}

}  // namespace

std::vector<int> contacts(const mjModel& model, int foot) {
  constexpr int kStandard = 1;  // contype and conaffinity of a geom by default
  std::vector<int> geoms;
  for (int geom = 0; geom < model.ngeom; ++geom)
    if (model.body_weldid[model.geom_bodyid[geom]] == model.body_weldid[foot] &&
        ((model.geom_contype[geom] | model.geom_conaffinity[geom]) & kStandard))
      geoms.push_back(geom);
  return geoms;
}

int part(const mjModel& model, int type, const std::string& name) {
  const int id = mj_name2id(&model, type, name.c_str());
  if (id < 0) throw std::invalid_argument(fmt::format("the model has no {} '{}'", mju_type2Str(type), name));
  return id;
}

std::string name_of(const mjModel& model, int type, int id) {
  const char* const name = id < 0 ? nullptr : mj_id2name(&model, type, id);
  return name ? name : "";
}

void pose_bodies(const mjModel& model, mjData& data) {
  for (int script = 0; script < model.nnumeric; ++script) {
    const int body = mj_name2id(&model, mjOBJ_BODY, mj_id2name(&model, mjOBJ_NUMERIC, script));
    const int actor = body < 0 ? -1 : model.body_mocapid[body];
    if (actor < 0) continue;
    const Eigen::Isometry3d X = pose_at(
        {model.numeric_data + model.numeric_adr[script], std::size_t(model.numeric_size[script])}, data.time);
    set_pose(data.mocap_pos + 3 * actor, data.mocap_quat + 4 * actor, X);
  }
  mj_kinematics(&model, &data);
}

bool is_actor(const mjModel& model, int geom) { return model.body_mocapid[model.geom_bodyid[geom]] >= 0; }

Eigen::Isometry3d geom_pose(const mjData& data, int geom) {
  return pose_in(data.geom_xpos + 3 * geom, data.geom_xmat + 9 * geom);
}

Eigen::Vector3d half_extents(const mjModel& model, int geom) {
  const Eigen::Vector3d size(model.geom_size + 3 * geom);
  switch (model.geom_type[geom]) {
    case mjGEOM_PLANE:
      return {size.x() > 0 ? size.x() : kEndless, size.y() > 0 ? size.y() : kEndless, 0};
    case mjGEOM_SPHERE:
      return Eigen::Vector3d::Constant(size.x());
    case mjGEOM_CAPSULE:
      return {size.x(), size.x(), size.x() + size.y()};
    case mjGEOM_CYLINDER:
      return {size.x(), size.x(), size.y()};
    default:
      return size;
  }
}

namespace {

// Only a height field is not centered: its base goes down and its hills go up.
Eigen::AlignedBox3d box_of(const mjModel& model, int geom) {
  const Eigen::Vector3d half = half_extents(model, geom);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  if (model.geom_type[geom] == mjGEOM_HFIELD)
    middle.z() = model.hfield_size[4 * model.geom_dataid[geom] + 2] - half.z();
  return {middle - half, middle + half};
}

}  // namespace

Eigen::AlignedBox3d box_around(const mjModel& model, const mjData& data, int geom) {
  return box_of(model, geom).transformed(geom_pose(data, geom));
}

double ray_distance(const mjModel& model, const mjData& data, int geom, const Eigen::Vector3d& from,
                    const Eigen::Vector3d& along) {
  const int type = model.geom_type[geom];
  if (type == mjGEOM_HFIELD) return mj_rayHfield(&model, &data, geom, from.data(), along.data());
  if (type == mjGEOM_MESH) return mj_rayMesh(&model, &data, geom, from.data(), along.data());
  return mju_rayGeom(data.geom_xpos + 3 * geom, data.geom_xmat + 9 * geom, model.geom_size + 3 * geom,
                     from.data(), along.data(), type);
}

std::vector<Eigen::Vector3d> corners(const mjModel& model, const mjData& data, int geom,
                                     const Eigen::Isometry3d& X) {
  Eigen::Isometry3d X_geom = X * geom_pose(data, geom);
  std::vector<Eigen::Vector3d> all;
  if (const int mesh = model.geom_dataid[geom]; model.geom_type[geom] == mjGEOM_MESH) {
    for (int i = 0; i < model.mesh_vertnum[mesh]; ++i)
      all.push_back(X_geom *
                    Eigen::Map<const Eigen::Vector3f>(model.mesh_vert + 3 * (model.mesh_vertadr[mesh] + i))
                        .cast<double>());
    return all;
  }
  if (model.geom_type[geom] == mjGEOM_SPHERE) X_geom.linear().setIdentity();
  const Eigen::AlignedBox3d box = box_of(model, geom);
  for (int i = 0; i < 8; ++i) all.push_back(X_geom * box.corner(Eigen::AlignedBox3d::CornerType(i)));
  return all;
}

Place place_of(const mjModel& model, const rig::Mount& mount) {
  if (mount.on_link()) return {upper_link(model, mount.link), rig::pose(mount)};
  const int camera = part(model, mjOBJ_CAMERA, "head_camera");
  return {model.cam_bodyid[camera], turned_pose_in(model.cam_pos + 3 * camera, model.cam_quat + 4 * camera) *
                                        camera_from_place() * rig::pose(mount)};
}

void mount_camera(mjModel& model, const rig::Mount& mount) {
  const Place place = place_of(model, mount);
  const int camera = part(model, mjOBJ_CAMERA, "head_camera");
  model.cam_bodyid[camera] = place.body;
  set_pose(model.cam_pos + 3 * camera, model.cam_quat + 4 * camera,
           place.X_BL * camera_from_place().inverse());
}

Model copy_of(const Model& model) { return Model(mj_copyModel(nullptr, model.get())); }

void mount_imu(mjModel& model, const rig::Mount& mount) {
  const int site = part(model, mjOBJ_SITE, "imu");
  const Eigen::Isometry3d X_BG = turned_pose_in(model.site_pos + 3 * site, model.site_quat + 4 * site);
  const Place place = mount.on_link() ? Place{upper_link(model, mount.link), rig::pose(mount)}
                                      : Place{model.site_bodyid[site], X_BG * rig::pose(mount)};
  model.site_bodyid[site] = place.body;
  model.site_sameframe[site] = 0;
  set_pose(model.site_pos + 3 * site, model.site_quat + 4 * site, place.X_BL);
}

std::optional<std::string> latest_warning() {
  if (last_warning[0] == '\0') return std::nullopt;
  std::string warning = last_warning.data();
  last_warning[0] = '\0';
  return warning;
}

}  // namespace sim::physics
