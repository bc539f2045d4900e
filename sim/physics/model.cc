#include "sim/physics/model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace sim::physics {
namespace {

std::array<char, 1000> last_warning{};

// A main file that only exists in memory, "in" the models folder so that relative paths start there.
std::unique_ptr<mjVFS, void (*)(mjVFS*)> main_file(const std::string& name, const std::string& text) {
  std::unique_ptr<mjVFS, void (*)(mjVFS*)> files(new mjVFS, [](mjVFS* vfs) {
    mj_deleteVFS(vfs);
    delete vfs;
  });
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), name.c_str(), static_cast<int>(text.size()));
  std::memcpy(files->filedata[0], text.data(), text.size());
  return files;
}

}  // namespace

void Free::operator()(mjModel_* model) const { mj_deleteModel(model); }
void Free::operator()(mjData_* data) const { mj_deleteData(data); }

Model load_model(const std::string& robot, const std::string& room, const std::filesystem::path& models,
                 Shapes shapes) {
  // MuJoCo's own handler waits for a key, and throwing through its C frames is not safe: the process ends.
  mju_user_error = [](const char* message) {
    std::fprintf(stderr, "gaitslam: MuJoCo: %s\n", message);
    std::fflush(nullptr);
    _exit(3);
  };
  mju_user_warning = [](const char* message) {
    std::snprintf(last_warning.data(), last_warning.size(), "%s", message);
  };
  for (const std::string& part : {robot, room}) {
    const std::filesystem::path file = models / (part + ".xml");
    if (!std::filesystem::is_regular_file(file)) throw std::runtime_error("no model " + file.string());
  }
  const std::string name = (models / (robot + "_in_" + room + ".xml")).string();
  const std::string discard = shapes == Shapes::colliding ? "<compiler discardvisual=\"true\"/>" : "";
  const std::string text = "<mujoco model=\"" + robot + " in " + room + "\">" + discard + "<include file=\"" +
                           robot + ".xml\"/><include file=\"" + room + ".xml\"/></mujoco>";
  const auto files = main_file(name, text);
  std::array<char, 1000> message{};
  Model model(mj_loadXML(name.c_str(), files.get(), message.data(), static_cast<int>(message.size())));
  if (!model)
    throw std::runtime_error("models " + robot + ".xml and " + room + ".xml do not load: " + message.data());
  return model;
}

namespace {

constexpr double kEndless = 1e6;  // m, half the size of a plane that has none

void set_pose(mjtNum* position, mjtNum* quaternion, const Eigen::Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  Eigen::Map<Eigen::Vector3d>(position, 3) = X.translation();
  Eigen::Map<Eigen::Vector4d>(quaternion, 4) << q.w(), q.vec();
}

// The axes forward, left, up in those of a camera of MuJoCo: x right, y up, looking along -z.
Eigen::Isometry3d camera_from_place() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() << 0, -1, 0, 0, 0, 1, -1, 0, 0;
  return X;
}

// Throws if a joint of a leg is between the body and the waist.
int upper_link(const mjModel& model, const std::string& link) {
  std::vector<std::string> links;
  for (int body = 1; body < model.nbody; ++body) {
    const std::string name = mj_id2name(&model, mjOBJ_BODY, body);
    if (model.body_weldid[body] != 0 && name.find("LEG") == name.npos) links.push_back(name);
    if (name == link && !links.empty() && links.back() == link) return body;
  }
  throw std::invalid_argument(
      fmt::format("link '{}' is not an upper-body link, expected one of {}", link, fmt::join(links, ", ")));
}

}  // namespace

int part(const mjModel& model, int type, const std::string& name) {
  const int id = mj_name2id(&model, type, name.c_str());
  if (id < 0) throw std::invalid_argument(fmt::format("the model has no {} '{}'", mju_type2Str(type), name));
  return id;
}

Eigen::Isometry3d geom_pose(const mjData& data, int geom) {
  return pose_in(data.geom_xpos + 3 * geom, data.geom_xmat + 9 * geom);
}

Eigen::Vector3d half_extents(const mjModel& model, int geom) {
  const Eigen::Vector3d size(model.geom_size + 3 * geom);
  switch (model.geom_type[geom]) {
    case mjGEOM_PLANE:
      return {size.x() > 0 ? size.x() : kEndless, size.y() > 0 ? size.y() : kEndless, 0};
    case mjGEOM_BOX:
    case mjGEOM_ELLIPSOID:
      return size;
    case mjGEOM_CAPSULE:
      return {size.x(), size.x(), size.x() + size.y()};
    case mjGEOM_CYLINDER:
      return {size.x(), size.x(), size.y()};
    default:
      return Eigen::Vector3d::Constant(model.geom_rbound[geom]);
  }
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

Models::Models(const std::string& robot, const std::string& room, const std::filesystem::path& folder)
    : on_floor(load_model(robot, kPhysicalRoom, folder, Shapes::colliding)),
      in_room(load_model(robot, room, folder)) {}

void Models::mount(const rig::Mount& camera, const rig::Mount& imu) {
  imu_is_moved = !imu.is_default();
  for (mjModel* model : {on_floor.get(), in_room.get()}) {
    if (!camera.is_default()) mount_camera(*model, camera);
    if (imu.is_default()) continue;
    const int site = part(*model, mjOBJ_SITE, "chest_imu");
    const Eigen::Isometry3d X_BG = turned_pose_in(model->site_pos + 3 * site, model->site_quat + 4 * site);
    const Place place = !imu.on_link() ? Place{model->site_bodyid[site], X_BG * rig::pose(imu)}
                                       : Place{upper_link(*model, imu.link), rig::pose(imu)};
    model->site_bodyid[site] = place.body;
    model->site_sameframe[site] = 0;
    set_pose(model->site_pos + 3 * site, model->site_quat + 4 * site, place.X_BL);
  }
}

std::optional<std::string> latest_warning() {
  if (last_warning[0] == '\0') return std::nullopt;
  std::string warning = last_warning.data();
  last_warning[0] = '\0';
  return warning;
}

std::vector<std::string> joint_names() {
  std::vector<std::string> names;
  const std::array<std::pair<const char*, int>, 6> groups{
      {{"RLEG", 6}, {"LLEG", 6}, {"CHEST", 2}, {"HEAD", 2}, {"RARM", 7}, {"LARM", 7}}};
  for (const auto& [group, count] : groups)
    for (int i = 0; i < count; ++i) names.push_back(fmt::format("{}_JOINT{}", group, i));
  return names;
}

}  // namespace sim::physics
