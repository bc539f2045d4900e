#include "sim/physics/nominal_body.h"

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <utility>

#include "sim/physics/model.h"

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

}  // namespace

walking::WholeBody nominal_body(const std::string& robot, const std::filesystem::path& models) {
  return nominal_body(load_model(robot, kPhysicalRoom, models, Shapes::colliding));
}

walking::WholeBody nominal_body(Model on_floor) {
  const auto body = std::make_shared<NominalBody>(std::move(on_floor));
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
