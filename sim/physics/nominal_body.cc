#include "sim/physics/nominal_body.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "sim/physics/model.h"
#include "walking/hrp2.h"

namespace sim::physics {
namespace {

class NominalBody {
 public:
  explicit NominalBody(Model on_floor) : model_(std::move(on_floor)), data_(mj_makeData(model_.get())) {
    for (int joint = 0; joint < walking::kJoints; ++joint) {
      // The actuators are in the order of JointVector.
      velocity_[joint] = model_->jnt_dofadr[model_->actuator_trnid[2 * joint]];
    }
  }

  walking::BodyMomentum momentum(const walking::BodyMotion& motion);

 private:
  void place(const walking::BodyMotion& motion);

  Model model_;
  Data data_;
  std::array<int, walking::kJoints> velocity_{};
};

void NominalBody::place(const walking::BodyMotion& motion) {
  Eigen::Map<Eigen::VectorXd>(data_->qpos, model_->nq) = robot_positions(*model_, motion.pose);
  const Eigen::Quaterniond turn(motion.pose.X_PB.linear());
  // The velocity of a free joint: linear in the world, angular in the body.
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(data_->qvel) << motion.v, turn.conjugate() * motion.w;
  for (int joint = 0; joint < walking::kJoints; ++joint) data_->qvel[velocity_[joint]] = motion.dq[joint];
}

walking::BodyMomentum NominalBody::momentum(const walking::BodyMotion& motion) {
  place(motion);
  mj_kinematics(model_.get(), data_.get());
  mj_comPos(model_.get(), data_.get());
  mj_comVel(model_.get(), data_.get());
  mj_subtreeVel(model_.get(), data_.get());
  const int waist = model_->jnt_bodyid[0];
  const auto of_waist = [&](const mjtNum* all) { return Eigen::Vector3d(all + 3 * waist); };
  const double mass = model_->body_subtreemass[waist];
  return {mass, of_waist(data_->subtree_com), mass * of_waist(data_->subtree_linvel),
          of_waist(data_->subtree_angmom)};
}

// Rounding in the model file stays far below these.
constexpr double kLengthTolerance_m = 1e-3, kComTolerance_m = 3e-3, kMassTolerance = 0.01;

[[noreturn]] void reject(const mjModel& model, const std::string& what) {
  throw std::runtime_error(
      fmt::format("model {}: {}; the plan is made for the nominal HRP-2 (models/README.md)",
                  std::string(model.names), what));
}

/// Joint positions of the model in this posture, in the waist frame.
class Posed {
 public:
  Posed(const mjModel& model, const walking::JointVector& q) : model_(model), data_(mj_makeData(&model)) {
    Eigen::Map<Eigen::VectorXd>(data_->qpos, model.nq) =
        robot_positions(model, {Eigen::Isometry3d::Identity(), q});
    mj_kinematics(&model, data_.get());
  }

  Eigen::Vector3d joint(int actuator) const {
    return Eigen::Vector3d(data_->xanchor + 3 * model_.actuator_trnid[2 * actuator]);
  }

  Eigen::Isometry3d body(int id) const {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(data_->xpos + 3 * id);
    pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data_->xmat + 9 * id);
    return pose;
  }

 private:
  const mjModel& model_;
  Data data_;
};

void require_length(const mjModel& model, const std::string& what, double length, double nominal) {
  if (std::abs(length - nominal) > kLengthTolerance_m)
    reject(model, fmt::format("{} is {:.3f} m, expected {:.3f} m", what, length, nominal));
}

void require_lengths(const mjModel& model) {
  using namespace walking::hrp2;
  const Posed zero(model, walking::JointVector::Zero());
  for (const bool left : {false, true}) {
    const std::string side = left ? "left" : "right";
    const int leg = left ? kLeftLeg : kRightLeg, elbow = (left ? kLeftArm : kRightArm) + kElbow;
    const Eigen::Vector3d hip = zero.joint(leg + 2), knee = zero.joint(leg + 3), ankle = zero.joint(leg + 4);
    require_length(model, "the " + side + " thigh", hip.z() - knee.z(), kThigh);
    require_length(model, "the " + side + " shank", knee.z() - ankle.z(), kShank);
    require_length(model, "the " + side + " upper arm",
                   (zero.joint(elbow) - zero.joint(elbow - kElbow)).norm(), kUpperArm);
    require_length(model, "the " + side + " forearm", (zero.joint(elbow + 2) - zero.joint(elbow)).norm(),
                   kUpperArm);
  }
}

/// In half-sitting and with each joint of a leg moved, which shows its axis and the offsets.
void require_legs(const mjModel& model) {
  for (const walking::Side side : {walking::Side::right, walking::Side::left}) {
    const bool left = side == walking::Side::left;
    const std::string name = left ? "LLEG_SOLE" : "RLEG_SOLE";
    const int sole = mj_name2id(&model, mjOBJ_BODY, name.c_str());
    if (sole < 0) reject(model, "has no body " + name);
    const int leg = left ? walking::hrp2::kLeftLeg : walking::hrp2::kRightLeg;
    for (int moved = -1; moved < 6; ++moved) {
      walking::JointVector q = walking::hrp2::half_sitting();
      if (moved >= 0) q[leg + moved] += 0.3;
      const Eigen::Isometry3d error =
          walking::sole_in_waist(side, q.segment<6>(leg)).inverse() * Posed(model, q).body(sole);
      if (!error.isApprox(Eigen::Isometry3d::Identity(), kLengthTolerance_m))
        reject(model, fmt::format("{} is {:.1f} mm and {:.2f} deg from its place{}", name,
                                  1e3 * error.translation().norm(),
                                  Eigen::AngleAxisd(error.linear()).angle() * 180 / std::numbers::pi,
                                  moved < 0 ? "" : fmt::format(" after joint {} has moved", moved)));
    }
  }
}

void require_masses(const mjModel& model, const walking::BodyMomentum& still) {
  using namespace walking::hrp2;
  if (std::abs(still.mass / kMass - 1) > kMassTolerance)
    reject(model, fmt::format("its mass is {:.3f} kg, expected {:.3f} kg", still.mass, kMass));
  const Eigen::Vector3d error = still.com - kComInWaist;
  if (error.norm() > kComTolerance_m)
    reject(model, fmt::format("its center of mass is ({:.1f}, {:.1f}, {:.1f}) mm from its place",
                              1e3 * error.x(), 1e3 * error.y(), 1e3 * error.z()));
}

void require_nominal(const mjModel& model) {
  if (model.nu != walking::kJoints || model.njnt == 0 || model.jnt_type[0] != mjJNT_FREE)
    reject(model, fmt::format("has {} actuators, expected a free body with {}", model.nu, walking::kJoints));
  require_lengths(model);
  require_legs(model);
}

}  // namespace

walking::WholeBody nominal_body(const std::string& robot, const std::filesystem::path& models) {
  return nominal_body(load_model(robot, kPhysicalRoom, models, Shapes::colliding));
}

walking::WholeBody nominal_body(Model on_floor) {
  require_nominal(*on_floor);
  const mjModel& model = *on_floor;
  const auto body = std::make_shared<NominalBody>(std::move(on_floor));
  walking::BodyMotion still;
  still.pose.q = walking::hrp2::half_sitting();
  require_masses(model, body->momentum(still));
  return [body](const walking::BodyMotion& motion) { return body->momentum(motion); };
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
