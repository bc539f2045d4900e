#include "sim/physics/robot.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "sim/physics/adapted.h"
#include "sim/physics/nominal_body.h"

namespace sim::physics {
namespace {

using Eigen::Isometry3d, Eigen::Vector2d, Eigen::Vector3d;
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
      file_.fail("legs", e.what());
    }
    return std::move(robot_);
  }

 private:
  [[noreturn]] void fail_model(const std::string& message) const {
    throw std::invalid_argument(fmt::format("{}: {}", (file_.folder / file_.model).string(), message));
  }

  int base() const {
    const int body = mj_name2id(&m_, mjOBJ_BODY, file_.base.c_str());
    if (body < 0) file_.fail("base", fmt::format("the model has no body '{}'", file_.base));
    const int joint = m_.body_jntadr[body];
    if (joint != 0 || m_.jnt_type[joint] != mjJNT_FREE)
      file_.fail("base",
                 fmt::format("body '{}' has no free joint, expected the model's first joint", file_.base));
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
          return static_cast<int>(found - joints_.begin());
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
      if (made.parent >= 0) made.offset -= anchor(joints_[static_cast<std::size_t>(made.parent)]);
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
    if (found == robot_.joints.end())
      file_.fail(key, fmt::format("the model has no joint '{}' with a servo", name));
    return static_cast<int>(found - robot_.joints.begin());
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
      file_.fail(key, fmt::format("body '{}' is not on the link of {}", file_.feet[side].body,
                                  robot_.joints[static_cast<std::size_t>(leg.joints.back())].name));
    const Isometry3d X_WS = site_pose(sole);
    leg.X_FS = X_WS;
    leg.X_FS.pretranslate(-anchor(joints_[static_cast<std::size_t>(leg.joints.back())]));
    const RobotFile::Foot& foot_keys = file_.feet[side];
    leg.pad_stiffness << foot_keys.pad_roll_nm_rad, foot_keys.pad_pitch_nm_rad;
    leg.pad_lag_s = foot_keys.pad_lag_s;
    Eigen::AlignedBox3d shape;
    for (const int geom : contacts(m_, foot)) extend(shape, X_WS.inverse(), geom);
    leg.sole_min = shape.min().head<2>(), leg.sole_max = shape.max().head<2>();
    if (!(leg.sole_min.array() < leg.sole_max.array()).all())
      file_.fail(key,
                 fmt::format("body '{}' has no sole, expected geoms that touch the floor at several places",
                             file_.feet[side].body));
    if (!(std::abs(shape.min().z()) <= kSoleDepth))
      file_.fail(
          key, fmt::format("the contacts end {:.4g} m {} the point sole_m, expected this point on the ground",
                           std::abs(shape.min().z()), shape.min().z() > 0 ? "above" : "below"));
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
    robot_.R_link_imu = site_pose(imu).linear();
  }

  void read_posture() {
    robot_.posture = Eigen::VectorXd::Zero(m_.nu);
    for (const auto& [name, angle] : file_.posture_rad) {
      const std::string key = "posture_deg." + name;
      const int i = index(key, name);
      const walking::Joint& joint = robot_.joints[static_cast<std::size_t>(i)];
      constexpr double kDegree = std::numbers::pi / 180;
      if (angle < joint.lowest || angle > joint.highest)
        file_.fail(key, fmt::format("is {:g}, expected {:.4g} to {:.4g}, the joint's range", angle / kDegree,
                                    joint.lowest / kDegree, joint.highest / kDegree));
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

Robot read_robot(const mjModel& model, const RobotFile& file) { return RobotReader(model, file).read(); }

Models::Models(const RobotFile& file, const std::string& room, const std::filesystem::path& folder)
    : Models(adapt(file).root, file, room, folder) {}

Models::Models(const model_file::Element& adapted, const RobotFile& file, const std::string& room,
               const std::filesystem::path& folder)
    : on_floor(join(adapted, room, folder, Shapes::floor)),
      in_room(join(adapted, room, folder, Shapes::all)),
      robot(read_robot(*on_floor, file)),
      has_force_sensors(file.feet[0].force_sensor && file.feet[1].force_sensor) {}

controllers::RobotDescription describe(const Models& models, const RobotFile& file) {
  const mjModel& m = *models.on_floor;
  const Robot& robot = models.robot;
  controllers::RobotDescription description;
  description.measures_wrenches = models.has_force_sensors;
  description.model = to_xml(adapt(file).root);
  const Data data(mj_makeData(&m));
  Eigen::Map<Eigen::VectorXd>(data->qpos, m.nq) = robot_positions(m, {Isometry3d::Identity(), robot.posture});
  for (int i = 0; i < m.nu; ++i) {
    const int joint = m.actuator_trnid[2 * i], dof = m.jnt_dofadr[joint];
    description.motors.push_back(
        {.armature = m.dof_armature[dof], .kp = m.actuator_gainprm[mjNGAIN * i], .kd = m.dof_damping[dof]});
  }
  mj_kinematics(&m, data.get());
  const int imu = part(m, mjOBJ_SITE, "imu");
  description.X_BG.linear() = walking::imu_in_base(robot, robot.posture);
  description.X_BG.translation() = Vector3d(data->site_xpos + 3 * imu);
  for (const Side side : {Side::right, Side::left})
    description.X_BS[static_cast<std::size_t>(side)] =
        walking::sole_in_base(robot, side, walking::leg_angles(robot.leg(side), robot.posture));
  return description;
}

void Models::mount(const rig::Mount& camera, const rig::Mount& imu) {
  imu_is_moved = !imu.is_default();
  for (mjModel* model : {on_floor.get(), in_room.get()}) {
    if (!camera.is_default()) mount_camera(*model, camera);
    if (imu_is_moved) mount_imu(*model, imu);
  }
}

}  // namespace sim::physics
