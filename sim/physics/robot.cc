#include "sim/physics/robot.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "sim/physics/adapted.h"
#include "sim/physics/compiled.h"
#include "sim/physics/nominal_body.h"
#include "sim/physics/options.h"

namespace sim::physics {
namespace {

using Eigen::Isometry3d, Eigen::Vector2d, Eigen::Vector3d;
using model_file::Element;

constexpr double kNotLevel = 0.001;  // m

bool is_floor(const Element& geom) { return geom.get("contype") == std::to_string(model_file::kSteppedBits); }

/// Removes everything but shapes of class floor. Returns whether a plane or a height field is left.
bool keep_floors(Element& parent) {
  bool wide = false;
  std::erase_if(parent.children, [&](Element& child) {
    if (child.name == "body") wide |= keep_floors(child);
    const bool kept =
        child.name == "body" ? !child.children.empty() : child.name == "geom" && is_floor(child);
    wide |= kept && (child.get("type") == "plane" || child.get("type") == "hfield");
    return !kept;
  });
  return wide;
}

/// Returns a room's lights and shapes. Geoms of class floor have the contact bits kSteppedBits.
Element adapted_room(const fs::path& file) {
  const model_file::ModelFile room = read_room(file, schema());
  const Model compiled = load_mjcf(room.root, file.string());
  mjModel& m = *compiled;
  const Writer writer(m, room, "");
  const auto name = [&](int type, int id) { return writer.name(type, id); };
  if (m.njnt > 0)
    reject(room.named("joint", name(mjOBJ_JOINT, 0)), "", "is in a room, expected shapes that do not move");
  for (int light = 0; light < m.nlight; ++light)
    if (m.light_active[light] && !m.light_directional[light])
      reject(room.named("light", name(mjOBJ_LIGHT, light)), "directional",
             "is false, expected true: brightness must not depend on position");
  const Data data(mj_makeData(&m));
  mj_kinematics(&m, data.get());
  bool has_floor = false, is_wide = false;
  int plain = -1;
  for (int geom = 0; geom < m.ngeom; ++geom) {
    const bool is_plane = m.geom_type[geom] == mjGEOM_PLANE;
    if (is_plane && std::min(m.geom_size[3 * geom], m.geom_size[3 * geom + 1]) <= 0)
      reject(room.named("geom", name(mjOBJ_GEOM, geom)), "size", "is 0, expected positive half lengths");
    if (m.nuser_geom > 0 && m.geom_user[m.nuser_geom * geom] == 1) {
      m.geom_contype[geom] = m.geom_conaffinity[geom] = model_file::kSteppedBits;
      has_floor = true;
      is_wide |= is_plane || m.geom_type[geom] == mjGEOM_HFIELD;
    } else if (is_plane && name(mjOBJ_GEOM, geom) == "floor") {
      plain = geom;
    }
  }
  if (plain >= 0) {
    const Eigen::Isometry3d X = geom_pose(*data, plain);
    const Element& element = room.named("geom", "floor");
    if (is_wide)
      reject(element, "",
             "the plane 'floor' is not of class floor, but other planes or height fields are: "
             "expected the class floor for it, too, or no such plane");
    if (std::abs(X.translation().z()) > kNotLevel || X.linear()(2, 2) < 1 - kNotLevel * kNotLevel)
      reject(element, "",
             "the plane 'floor' is at z = {:.4g} m or tilted, expected z = 0, or class "
             "floor",
             X.translation().z());
  } else if (!has_floor) {
    reject(room.named("worldbody", ""), "",
           "has no plane named 'floor' and no shape of class floor, expected a floor to walk on");
  }
  Element root{"mujoco"};
  for (const Element& section : room.root.children)
    if (section.name == "visual") root.children.push_back(section);
  Element world{"worldbody"};
  writer.add_content(0, world);
  root.children.push_back(std::move(world));
  writer.add_sections(root);
  return root;
}

/// Adds actors to a room. Their scripts are numbers with the names of their bodies.
void add(Element& room, const std::vector<Actor>& actors) {
  static constexpr std::array kColors{"0.2 0.3 0.5 1", "0.6 0.2 0.2 1", "0.25 0.4 0.25 1", "0.5 0.4 0.3 1"};
  static constexpr std::array kTypes{"plane", "box", "sphere", "cylinder", "ellipsoid", "capsule"};
  Element& world = *std::ranges::find(room.children, "worldbody", &Element::name);
  Element scripts{"custom"};
  for (std::size_t i = 0; i < actors.size(); ++i) {
    const std::string name =
        fmt::format("{} {}", std::visit([](const auto& m) { return m.kName; }, actors[i]), i);
    scripts.add("numeric",
                {{"name", name}, {"data", fmt::format("{}", fmt::join(script_of(actors[i]), " "))}});
    Element& body = world.add("body", {{"name", name}, {"mocap", "true"}});
    for (const score::Surface& shape : shapes_of(actors[i])) {
      const Vector3d& p = shape.X_WS.translation();
      body.add("geom", {{"type", kTypes[std::size_t(shape.kind)]},
                        {"pos", fmt::format("{} {} {}", p.x(), p.y(), p.z())},
                        {"size", fmt::format("{} {} {}", shape.size.x(), shape.size.y(), shape.size.z())},
                        {"rgba", kColors[i % kColors.size()]},
                        {"group", "0"}});
    }
  }
  if (!actors.empty()) room.children.push_back(std::move(scripts));
}

/// Renames parts of a room that have the same name as a part of the robot.
void rename_clashes(Element& room, const Element& robot) {
  std::set<std::pair<std::string, std::string>> taken;
  robot.visit([&](const Element& each) { taken.emplace(each.name, each.get("name")); });
  room.visit([&](Element& each) {
    if (each.find("name") && taken.contains({each.name, each.get("name")}))
      each.set("name", each.get("name") + " of the room");
  });
}

/// Gives bodies the quaternions of the file to the last bit: the library normalizes them again.
void keep_quaternions(const Element& element, mjModel& m) {
  for (const Element& child : element.children) {
    if (child.name == "body") {
      keep_quaternions(child, m);
      const int body = mj_name2id(&m, mjOBJ_BODY, child.get("name").c_str());
      if (body < 0) continue;
      std::ranges::copy(numbers(child, "quat", 4, 4), m.body_quat + 4 * body);
      std::ranges::copy(numbers(*child.child("inertial"), "quat", 4, 4), m.body_iquat + 4 * body);
    }
  }
}

using walking::Leg, walking::Robot, walking::Side;

constexpr std::array kSides{"right", "left"};  // as walking::Side
constexpr double kSoleDepth = 0.005;           // m above the sole's point, for meshes

class RobotReader {
 public:
  RobotReader(const mjModel& model, const RobotFile& file)
      : m_(model), file_(file), data_(mj_makeData(&model)), base_(base()) {}

  Robot read() {
    robot_.name = file_.folder.filename();
    pose_at(Eigen::VectorXd::Zero(m_.nu));
    read_joints();
    for (std::size_t side = 0; side < 2; ++side) {
      robot_.legs[side].joints = indices(fmt::format("legs.{}", kSides[side]), file_.legs[side]);
      if (const auto arm = indices(fmt::format("arms.{}", kSides[side]), file_.arms[side]); arm.size() == 2)
        robot_.arms[side] = walking::Arm{arm[0], arm[1]};
      if (!robot_.legs[side].joints.empty()) read_sole(side);
    }
    read_imu();
    robot_.step = file_.step;
    read_posture();
    try {
      walking::measure(robot_);
    } catch (const std::invalid_argument& e) {
      file_.fail("legs", "{}", e.what());
    }
    return std::move(robot_);
  }

 private:
  [[noreturn]] void fail_model(const std::string& message) const {
    throw std::invalid_argument(fmt::format("{}: {}", (file_.folder / file_.model).string(), message));
  }

  int base() const {
    const int body = mj_name2id(&m_, mjOBJ_BODY, file_.base.c_str());
    if (body < 0) file_.fail("base", "the model has no body '{}'", file_.base);
    const int joint = m_.body_jntadr[body];
    if (joint != 0 || m_.jnt_type[joint] != mjJNT_FREE)
      file_.fail("base", "body '{}' has no free joint, expected the model's first joint", file_.base);
    return body;
  }

  /// Computes all poses with the base at the origin.
  void pose_at(const Eigen::VectorXd& q) {
    Eigen::Map<Eigen::VectorXd>(data_->qpos, m_.nq) = robot_positions(m_, {Isometry3d::Identity(), q});
    mj_kinematics(&m_, data_.get());
    mj_comPos(&m_, data_.get());
  }

  Vector3d anchor(int joint) const { return Vector3d(data_->xanchor + 3 * joint); }

  /// Returns the joint of the robot that moves this body, or -1 if it is part of the base.
  int mover(int body) const {
    for (; body != base_ && body != 0; body = m_.body_parentid[body])
      for (int k = m_.body_jntnum[body]; k-- > 0;)
        if (const auto found = std::ranges::find(joints_, m_.body_jntadr[body] + k); found != joints_.end())
          return int(found - joints_.begin());
    return -1;
  }

  void read_joints() {
    for (int i = 0; i < m_.nu; ++i) {
      const int joint = m_.actuator_trnid[2 * i];
      const std::string name = name_of(m_, mjOBJ_JOINT, joint);
      if (i > 0 && joint <= joints_.back())
        fail_model(fmt::format("the servo of {} is out of the joints' order", name));
      walking::Joint& made = robot_.joints.emplace_back();
      made.name = name;
      const int body = m_.jnt_bodyid[joint];
      const bool on_same = !joints_.empty() && m_.jnt_bodyid[joints_.back()] == body;
      made.parent = on_same ? i - 1 : mover(m_.body_parentid[body]);
      made.offset = anchor(joint);
      if (made.parent >= 0) made.offset -= anchor(joints_[std::size_t(made.parent)]);
      made.axis = Vector3d(data_->xaxis + 3 * joint);
      if (m_.jnt_limited[joint])
        made.lowest = m_.jnt_range[2 * joint], made.highest = m_.jnt_range[2 * joint + 1];
      if (m_.actuator_forcelimited[i])
        made.lowest_effort = m_.actuator_forcerange[2 * i], made.effort = m_.actuator_forcerange[2 * i + 1];
      joints_.push_back(joint);
    }
  }

  int index(const std::string& key, const std::string& name) const {
    const auto found = std::ranges::find(robot_.joints, name, &walking::Joint::name);
    if (found == robot_.joints.end()) file_.fail(key, "the model has no joint '{}' with a servo", name);
    return int(found - robot_.joints.begin());
  }
  std::vector<int> indices(const std::string& key, const std::vector<std::string>& names) const {
    std::vector<int> all;
    for (const std::string& name : names) all.push_back(index(key, name));
    return all;
  }

  int site(const std::string& name) const {
    const int found = mj_name2id(&m_, mjOBJ_SITE, name.c_str());
    if (found < 0) fail_model(fmt::format("has no site '{}'", name));
    return found;
  }
  Isometry3d site_pose(int site) const {
    return pose_in(data_->site_xpos + 3 * site, data_->site_xmat + 9 * site);
  }

  void read_sole(std::size_t side) {
    Leg& leg = robot_.legs[side];
    const std::string key = fmt::format("feet.{}", kSides[side]);
    const int sole = site(fmt::format("{}_sole", kSides[side])), foot = m_.site_bodyid[sole];
    if (mover(foot) != leg.joints.back())
      file_.fail(key, "body '{}' is not on the link of {}", file_.feet[side].body,
                 robot_.joints[std::size_t(leg.joints.back())].name);
    const Isometry3d X_WS = site_pose(sole);
    leg.X_FS = X_WS;
    leg.X_FS.pretranslate(-anchor(joints_[std::size_t(leg.joints.back())]));
    const RobotFile::Foot& foot_keys = file_.feet[side];
    leg.pad_stiffness << foot_keys.pad_roll_nm_rad, foot_keys.pad_pitch_nm_rad;
    leg.pad_lag_s = foot_keys.pad_lag_s;
    Eigen::AlignedBox3d shape;
    for (const int geom : contacts(m_, foot)) extend(shape, X_WS.inverse(), geom);
    leg.sole_min = shape.min().head<2>(), leg.sole_max = shape.max().head<2>();
    if (!(leg.sole_min.array() < leg.sole_max.array()).all())
      file_.fail(key, "body '{}' has no sole, expected geoms that touch the floor at several places",
                 file_.feet[side].body);
    if (!(std::abs(shape.min().z()) <= kSoleDepth))
      file_.fail(key, "the contacts end {:.4g} m {} the point sole_m, expected this point on the ground",
                 std::abs(shape.min().z()), shape.min().z() > 0 ? "above" : "below");
    for (int body = foot; mover(body) == leg.joints.back(); body = m_.body_parentid[body])
      for (int k = m_.body_jntnum[body]; k-- > 0;) add_spring(leg, X_WS, m_.body_jntadr[body] + k);
  }

  /// A sphere touches the floor below its center; vertices of a mesh count only if they are as low as the
  /// sole.
  void extend(Eigen::AlignedBox3d& sole, const Isometry3d& X_SW, int geom) const {
    for (Vector3d p : corners(m_, *data_, geom, X_SW)) {
      if (m_.geom_type[geom] == mjGEOM_SPHERE)
        p.head<2>() = (X_SW * geom_pose(*data_, geom)).translation().head<2>();
      if (m_.geom_type[geom] != mjGEOM_MESH || p.z() <= kSoleDepth) sole.extend(p);
    }
  }

  /// Joints between ankle and sole that have no servo are springs.
  void add_spring(Leg& leg, const Isometry3d& X_WS, int joint) const {
    if (std::ranges::find(joints_, joint) != joints_.end()) return;
    if (!(m_.jnt_stiffness[joint] > 0) || m_.jnt_type[joint] == mjJNT_BALL)
      fail_model(fmt::format("joint {} below the ankle has neither a servo nor a stiffness",
                             name_of(m_, mjOBJ_JOINT, joint)));
    leg.bush.insert(
        leg.bush.begin(),
        {m_.jnt_type[joint] == mjJNT_HINGE, X_WS.linear().transpose() * Vector3d(data_->xaxis + 3 * joint),
         m_.jnt_stiffness[joint], m_.dof_damping[m_.jnt_dofadr[joint]] / m_.jnt_stiffness[joint]});
  }

  void read_imu() {
    const int imu = site("imu");
    robot_.chest = mover(m_.site_bodyid[imu]);
    robot_.X_link_imu = site_pose(imu);
    if (robot_.chest >= 0) robot_.X_link_imu.pretranslate(-anchor(joints_[std::size_t(robot_.chest)]));
  }

  void read_posture() {
    robot_.posture = Eigen::VectorXd::Zero(m_.nu);
    for (const auto& [name, angle] : file_.posture_rad) {
      const std::string key = "posture_deg." + name;
      const int i = index(key, name);
      const walking::Joint& joint = robot_.joints[std::size_t(i)];
      constexpr double kDegree = std::numbers::pi / 180;
      if (angle < joint.lowest || angle > joint.highest)
        file_.fail(key, "is {:g}, expected {:.4g} to {:.4g}, the joint's range", angle / kDegree,
                   joint.lowest / kDegree, joint.highest / kDegree);
      robot_.posture[i] = angle;
    }
    pose_at(robot_.posture);
    robot_.mass = m_.body_subtreemass[base_];
    robot_.com = Vector3d(data_->subtree_com + 3 * base_);
    robot_.com.y() = 0;
  }

  const mjModel& m_;
  const RobotFile& file_;
  Data data_;
  int base_;
  std::vector<int> joints_;  // indices in the model
  Robot robot_;
};

}  // namespace

Model join(const Element& robot, const std::string& room, const fs::path& models, Shapes shapes,
           const std::vector<Actor>& actors) {
  const auto file_of = [&](const std::string& name) {
    return NameOrPath(name).is_path() ? fs::path(name) : models / (name + ".xml");
  };
  std::vector<Element> parts{robot, adapted_room(file_of(room))};
  Element whole{"mujoco", robot.attributes};
  if (shapes == Shapes::floor) {
    whole.add("compiler", {{"discardvisual", "true"}});
    Element& world = *std::ranges::find(parts[1].children, "worldbody", &Element::name);
    const bool wide = keep_floors(world);
    const bool none = world.children.empty();
    if (!wide) parts.insert(parts.begin() + 1, adapted_room(file_of(kPhysicalRoom)));
    if (none) parts.pop_back();
  } else {
    add(parts[1], actors);
    // Loading takes a step. Its list of pairs of bodies would overflow if more than half of them had planes.
    whole.add("option").add("flag", {{"contact", "disable"}});
  }
  for (Element& part : parts) {
    if (&part != &parts[0]) rename_clashes(part, robot);
    std::ranges::move(part.children, std::back_inserter(whole.children));
  }
  Model model = load_mjcf(whole, fmt::format("the robot in {}", room));
  model->opt.disableflags &= ~mjDSBL_CONTACT;
  keep_quaternions(*robot.child("worldbody"), *model);
  mj_setConst(model.get(), Data(mj_makeData(model.get())).get());
  return model;
}

Model load_model(const RobotFile& robot, const std::string& room, const fs::path& models, Shapes shapes,
                 const std::vector<Actor>& actors) {
  return join(adapt(robot).root, room, models, shapes, actors);
}

Robot read_robot(const mjModel& model, const RobotFile& file) { return RobotReader(model, file).read(); }

Models::Models(const RobotFile& file, const std::string& room, const fs::path& folder,
               const std::vector<Actor>& actors)
    : Models(adapt(file).root, file, room, folder, actors) {}

Models::Models(const model_file::Element& adapted, const RobotFile& file, const std::string& room,
               const fs::path& folder, const std::vector<Actor>& actors)
    : on_floor(join(adapted, room, folder, Shapes::floor)),
      in_room(join(adapted, room, folder, Shapes::all, actors)),
      robot(read_robot(*on_floor, file)),
      has_force_sensors(file.feet[0].force_sensor && file.feet[1].force_sensor) {}

controllers::RobotDescription describe(const Models& models, const RobotFile& file) {
  const mjModel& m = *models.on_floor;
  const Robot& robot = models.robot;
  controllers::RobotDescription description;
  description.measures_wrenches = models.has_force_sensors;
  description.model = to_xml(adapt(file).root);
  for (int i = 0; i < m.nu; ++i) {
    const int joint = m.actuator_trnid[2 * i], dof = m.jnt_dofadr[joint];
    description.motors.push_back(
        {.armature = m.dof_armature[dof], .kp = m.actuator_gainprm[mjNGAIN * i], .kd = m.dof_damping[dof]});
  }
  description.X_BG = walking::imu_in_base(robot, robot.posture);
  for (const Side side : {Side::right, Side::left})
    description.X_BS[std::size_t(side)] =
        walking::sole_in_base(robot, side, walking::leg_angles(robot.leg(side), robot.posture));
  return description;
}

void Models::mount(const rig::Mount& camera, const rig::Mount& imu) {
  imu_is_moved = !imu.is_default();
  for (mjModel* model : {on_floor.get(), in_room.get()}) {
    if (!camera.is_default()) mount_camera(*model, camera);
    if (imu_is_moved) mount_imu(*model, imu);
  }
  if (!imu_is_moved) return;
  const mjModel& m = *on_floor;
  const Data data(mj_makeData(&m));
  Eigen::Map<Eigen::VectorXd>(data->qpos, m.nq) = robot_positions(m, {Isometry3d::Identity(), robot.posture});
  mj_kinematics(&m, data.get());
  const Isometry3d X_BG = walking::imu_in_base(robot, robot.posture);
  const Vector3d p_BG(data->site_xpos + 3 * part(m, mjOBJ_SITE, "imu"));
  robot.X_link_imu.translation() += robot.X_link_imu.linear() * (X_BG.inverse() * p_BG);
}

}  // namespace sim::physics
