#include "sim/physics/nominal_body.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace sim::physics {
namespace {

walking::BodyMomentum momentum(const mjModel& model, mjData& data, const walking::BodyMotion& motion) {
  Eigen::Map<Eigen::VectorXd>(data.qpos, model.nq) = robot_positions(model, motion.pose);
  const Eigen::Quaterniond turn(motion.pose.X_PB.linear());
  // The velocity of a free joint: linear in the world, angular in the body.
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(data.qvel) << motion.v, turn.conjugate() * motion.w;
  // The actuators are in the order of JointVector.
  for (int joint = 0; joint < walking::kJoints; ++joint)
    data.qvel[model.jnt_dofadr[model.actuator_trnid[2 * joint]]] = motion.dq[joint];
  mj_kinematics(&model, &data);
  mj_comPos(&model, &data);
  mj_comVel(&model, &data);
  mj_subtreeVel(&model, &data);
  const int waist = model.jnt_bodyid[0];
  const auto of_waist = [&](const mjtNum* all) { return Eigen::Vector3d(all + 3 * waist); };
  const double mass = model.body_subtreemass[waist];
  return {mass, of_waist(data.subtree_com), mass * of_waist(data.subtree_linvel),
          of_waist(data.subtree_angmom)};
}

/// The bodies of the nominal robot, of its right side for limbs: name, parent, place in it (m), mass (kg),
/// center of mass (m), inertia (kg m²), axis and range of the joint (rad). models/README.md has the sources.
constexpr const char* kLinks = R"(
BODY        world       0 0 0 15.0295 -.01435 0 .23285 .2254 .1733 .1733 - 0 0
RLEG_LINK0  BODY        0 -.06 0 1.23548 -.00664 .00461 0 .002059 .002059 .002059 z -.7854 .5236
RLEG_LINK1  RLEG_LINK0  0 0 0 .80553 -.00664 -.04 -.00292 .001101 .001343 .001101 x -.61086 .34907
RLEG_LINK2  RLEG_LINK1  0 0 0 2.07632 .00346 -.06566 -.15168 .01566 .01606 .004585 y -2.1817 .73304
RLEG_LINK3  RLEG_LINK2  0 -.035 -.3 1.74762 .01799 -.03066 -.13839 .01287 .01318 .003219 y -.034907 2.618
RLEG_LINK4  RLEG_LINK3  0 0 -.3 .65375 0 -.003 -.00242 .0006973 .0006973 .0006973 y -1.309 .73304
RLEG_LINK5  RLEG_LINK4  0 0 0 .63877 .00264 -.00469 -.06538 .001275 .003327 .00408 x -.34907 .61086
RLEG_SOLE   RLEG_LINK5  0 0 -.105 1 .00264 -.00469 .03962 .001995 .005208 .006387 - 0 0
CHEST_LINK0 BODY        .032 0 .3507 .786369 -.0158 0 0 .001363 .001075 .001599 z -.7854 .7854
CHEST_LINK1 CHEST_LINK0 0 0 0 11.5246 -.02905 .0075 .12076 .2228 .1998 .1736 y -.087266 1.0472
HEAD_LINK0  CHEST_LINK1 -.007 0 .2973 .374766 -.00088 0 0 .0002249 .0002249 .0002249 z -.7854 .7854
HEAD_LINK1  HEAD_LINK0  0 0 0 .993355 .01299 .00169 .10876 .004305 .004801 .003742 y -.5236 .7854
RARM_LINK0  CHEST_LINK1 .008 -.25 .181 .810076 -.02339 0 -.00015 .001094 .001094 .001094 y -3.1416 1.0472
RARM_LINK1  RARM_LINK0  0 0 0 1.03448 0 -.01204 -.04 .00194 .00194 .001396 x -1.6581 .17453
RARM_LINK2  RARM_LINK1  0 0 0 1.59929 -.00543 -.01413 -.14713 .008756 .008756 .002159 z -1.6057 1.6057
RARM_LINK3  RARM_LINK2  0 0 -.25 .77725 0 0 -.1 .001347 .001347 .0008291 y -2.3911 .034907
RARM_LINK4  RARM_LINK3  0 0 0 .554669 0 0 -.15623 .0006887 .0006887 .000453 z -1.6057 1.6057
RARM_LINK5  RARM_LINK4  0 0 -.25 .573818 .00361 0 -.09311 .001937 .001784 .0006216 y -1.6057 1.6057
RARM_LINK6  RARM_LINK5  .00361 0 -.09311 .5726481 0 0 0 .001933 .00178 .0006204 x -1 1
)";

/// Parts on the bodies, of the right leg for both: name, body, place (m), orientation (w x y z).
constexpr const char* kMounts = R"(
chest_imu    CHEST_LINK1  -0.13 0 0.118      1 0 0 0
head_camera  HEAD_LINK1   0.08 0 0.103       0.5 0.5 -0.5 -0.5
RLEG_SOLE    RLEG_SOLE    0 0 0              1 0 0 0
RLEG_PAD0    RLEG_SOLE    0.13 0.069 0.005   1 0 0 0
RLEG_PAD1    RLEG_SOLE    0.13 -0.069 0.005  1 0 0 0
RLEG_PAD2    RLEG_SOLE    -0.1 0.069 0.005   1 0 0 0
RLEG_PAD3    RLEG_SOLE    -0.1 -0.069 0.005  1 0 0 0
)";

/// Compares a model with the nominal robot. Throws std::runtime_error that names what differs.
class Comparison {
 public:
  explicit Comparison(const mjModel& model) : m_(model) {
    using namespace walking::hrp2;
    const std::vector<std::string> joints = joint_names();
    if (m_.nu != walking::kJoints || m_.njnt == 0 || m_.jnt_type[0] != mjJNT_FREE)
      reject(fmt::format("has {} actuators, expected a free body with {}", m_.nu, walking::kJoints));
    for (int i = 0; i < m_.nu; ++i)
      require_same(fmt::format("the joint of actuator {}", i),
                   mj_id2name(&m_, mjOBJ_JOINT, m_.actuator_trnid[2 * i]),
                   joints[static_cast<std::size_t>(i)]);
    std::istringstream links(kLinks), mounts(kMounts);
    for (Link link; links >> link.name >> link.parent && read(links, link.numbers) && links >> link.axis &&
                    read(links, link.range);) {
      require(link);
      if (!link.name.starts_with('R')) continue;
      // The left side is its image: y, and the angles about x and z, change their signs.
      for (std::string* const name : {&link.name, &link.parent})
        if (name->starts_with('R')) name->front() = 'L';
      for (const int y : {1, 5}) link.numbers[y] = 0 - link.numbers[y];
      if (link.axis != 'y') link.range = {-link.range[1], -link.range[0]};
      require(link);
    }
    for (Mount mount; mounts >> mount.name >> mount.body && read(mounts, mount.numbers);) {
      require(mount);
      if (mount.name.starts_with('R')) mount.name.front() = mount.body.front() = 'L', require(mount);
    }
    for (const std::string leg : {"RLEG_BUSH_", "LLEG_BUSH_"})
      for (const auto& [name, stiffness] : {std::pair("Z", kBushUp_n_m),
                                            {"YAW", kBushYaw_nm_rad},
                                            {"PITCH", kBushPitch_nm_rad},
                                            {"ROLL", kBushRoll_nm_rad}})
        require_near(leg + name + ": its stiffness", m_.jnt_stiffness + id(mjOBJ_JOINT, leg + name),
                     &stiffness, 1, kFraction * stiffness);
    require_near("its whole mass, kg,", m_.body_subtreemass + m_.jnt_bodyid[0], &kMass, 1, kFraction);
    if (constexpr int kBushes = 8; m_.njnt != 1 + m_.nu + kBushes)
      reject(fmt::format("has {} joints, expected {}", m_.njnt, 1 + m_.nu + kBushes));
  }

 private:
  /// Rounding in the model file stays far below these.
  static constexpr double kPlace_m = 1e-4, kAngle = 1e-3, kFraction = 1e-3;

  struct Link {
    std::string name, parent;
    std::array<double, 10> numbers{};  // place, mass, center of mass, inertia
    char axis = '-';
    std::array<double, 2> range{};
  };
  struct Mount {
    std::string name, body;
    std::array<double, 7> numbers{};  // place, quaternion
  };

  template <std::size_t n>
  static bool read(std::istream& text, std::array<double, n>& numbers) {
    for (double& number : numbers) text >> number;
    return bool(text);
  }

  void require(const Link& link) const {
    const int body = id(mjOBJ_BODY, link.name), joint = m_.body_jntadr[body];
    const double* const n = link.numbers.data();
    require_same(link.name + ": its parent", mj_id2name(&m_, mjOBJ_BODY, m_.body_parentid[body]),
                 link.parent);
    if (link.parent != "world")
      require_near(link.name + ": its place in " + link.parent + ", m,", m_.body_pos + 3 * body, n, 3,
                   kPlace_m);
    require_turn(link.name, m_.body_quat + 4 * body);
    require_near(link.name + ": its mass, kg,", m_.body_mass + body, n + 3, 1, kFraction * n[3]);
    require_near(link.name + ": its center of mass, m,", m_.body_ipos + 3 * body, n + 4, 3, kPlace_m);
    require_near(link.name + ": its inertia, kg m^2,", m_.body_inertia + 3 * body, n + 7, 3,
                 kFraction * *std::max_element(n + 7, n + 10));
    require_turn(link.name + ": its inertia", m_.body_iquat + 4 * body);
    if (link.axis == '-') return;
    if (joint < 0) reject(link.name + " has no joint, expected one");
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(link.axis - 'x'), origin = Eigen::Vector3d::Zero();
    require_near(link.name + ": the axis of its joint", m_.jnt_axis + 3 * joint, axis.data(), 3, kAngle);
    require_near(link.name + ": the place of its joint, m,", m_.jnt_pos + 3 * joint, origin.data(), 3,
                 kPlace_m);
    require_near(link.name + ": the range of its joint, rad,", m_.jnt_range + 2 * joint, link.range.data(), 2,
                 kAngle);
  }

  void require(const Mount& mount) const {
    const bool camera = mount.name.ends_with("camera"), pad = mount.name.find("PAD") != std::string::npos;
    const int part = id(camera ? mjOBJ_CAMERA : pad ? mjOBJ_GEOM : mjOBJ_SITE, mount.name);
    const int* const bodies = camera ? m_.cam_bodyid : pad ? m_.geom_bodyid : m_.site_bodyid;
    const double *const place = camera ? m_.cam_pos
                                : pad  ? m_.geom_pos
                                       : m_.site_pos,
                        *const turn = camera ? m_.cam_quat
                                      : pad  ? m_.geom_quat
                                             : m_.site_quat;
    require_same(mount.name + ": its body", mj_id2name(&m_, mjOBJ_BODY, bodies[part]), mount.body);
    require_near(mount.name + ": its place in " + mount.body + ", m,", place + 3 * part, mount.numbers.data(),
                 3, kPlace_m);
    const double* const q = mount.numbers.data() + 3;
    require_turn(mount.name, turn + 4 * part, {q[0], q[1], q[2], q[3]});
  }

  int id(mjtObj type, const std::string& name) const {
    const int found = mj_name2id(&m_, type, name.c_str());
    if (found < 0) reject(fmt::format("has no {} {}", mju_type2Str(type), name));
    return found;
  }

  void require_same(const std::string& what, const std::string& is, const std::string& expected) const {
    if (is != expected) reject(fmt::format("{} is {}, expected {}", what, is, expected));
  }

  void require_near(const std::string& what, const double* is, const double* expected, int count,
                    double most) const {
    for (int i = 0; i < count; ++i)
      if (!(std::abs(is[i] - expected[i]) <= most))
        reject(fmt::format("{} is {:.6g}, expected {:.6g}", what, fmt::join(is, is + count, " "),
                           fmt::join(expected, expected + count, " ")));
  }

  void require_turn(const std::string& what, const double* wxyz,
                    const Eigen::Quaterniond& expected = Eigen::Quaterniond::Identity()) const {
    const double angle = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).angularDistance(expected);
    if (angle > kAngle)
      reject(fmt::format("{} is turned by {:.2f} deg from its orientation, expected 0", what,
                         angle * 180 / std::numbers::pi));
  }

  [[noreturn]] void reject(const std::string& what) const {
    throw std::runtime_error(
        fmt::format("model {}: {}; the plan is made for the nominal HRP-2 (models/README.md)",
                    std::string(m_.names), what));
  }

  const mjModel& m_;
};

}  // namespace

walking::WholeBody nominal_body(const std::string& robot, const std::filesystem::path& models) {
  return nominal_body(load_model(robot, kPhysicalRoom, models, Shapes::colliding));
}

walking::WholeBody nominal_body(Model on_floor) {
  const Comparison nominal(*on_floor);
  const std::shared_ptr<const mjModel> model(std::move(on_floor));
  const std::shared_ptr<mjData> data(Data(mj_makeData(model.get())));
  return [=](const walking::BodyMotion& motion) { return momentum(*model, *data, motion); };
}

Eigen::VectorXd robot_positions(const mjModel& model, const walking::BodyPose& pose) {
  Eigen::VectorXd positions = Eigen::Map<const Eigen::VectorXd>(model.qpos0, model.nq);
  const Eigen::Quaterniond turn(pose.X_PB.linear());
  positions.head<7>() << pose.X_PB.translation(), turn.w(), turn.vec();
  // The actuators are in the order of JointVector.
  for (int joint = 0; joint < walking::kJoints; ++joint)
    positions[model.jnt_qposadr[model.actuator_trnid[2 * joint]]] = pose.q[joint];
  return positions;
}

}  // namespace sim::physics
