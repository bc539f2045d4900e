#include "sim/physics/nominal_body.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <array>
#include <cmath>
#include <stdexcept>

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
  Model model_;
  Data data_;
  std::array<int, walking::kJoints> velocity_{};
};

walking::BodyMomentum NominalBody::momentum(const walking::BodyMotion& motion) {
  Eigen::Map<Eigen::VectorXd>(data_->qpos, model_->nq) = robot_positions(*model_, motion.pose);
  const Eigen::Quaterniond turn(motion.pose.X_PB.linear());
  // The velocity of a free joint: linear in the world, angular in the body.
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(data_->qvel) << motion.v, turn.conjugate() * motion.w;
  for (int joint = 0; joint < walking::kJoints; ++joint) data_->qvel[velocity_[joint]] = motion.dq[joint];
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

/// The pose of a body in the waist in this posture.
Eigen::Isometry3d body_in_waist(const mjModel& model, const walking::JointVector& q, int body) {
  const Data data(mj_makeData(&model));
  Eigen::Map<Eigen::VectorXd>(data->qpos, model.nq) =
      robot_positions(model, {Eigen::Isometry3d::Identity(), q});
  mj_kinematics(&model, data.get());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(data->xpos + 3 * body);
  pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9 * body);
  return pose;
}

/// In half-sitting and with each joint of a leg moved, which shows its axis, the lengths and the offsets.
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
          walking::sole_in_waist(side, q.segment<6>(leg)).inverse() * body_in_waist(model, q, sole);
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

}  // namespace

walking::WholeBody nominal_body(const std::string& robot, const std::filesystem::path& models) {
  return nominal_body(load_model(robot, kPhysicalRoom, models, Shapes::colliding));
}

walking::WholeBody nominal_body(Model on_floor) {
  const mjModel& model = *on_floor;
  if (model.nu != walking::kJoints || model.njnt == 0 || model.jnt_type[0] != mjJNT_FREE)
    reject(model, fmt::format("has {} actuators, expected a free body with {}", model.nu, walking::kJoints));
  require_legs(model);
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
