#include "sim/physics/nominal_body.h"

#include <mujoco/mujoco.h>

namespace sim::physics {
namespace {

walking::BodyMomentum momentum(const mjModel& model, mjData& data, const walking::BodyMotion& motion) {
  Eigen::Map<Eigen::VectorXd>(data.qpos, model.nq) = robot_positions(model, motion.pose);
  const Eigen::Quaterniond turn(motion.pose.X_PB.linear());
  // The velocity of a free joint: linear in the world, angular in the body.
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(data.qvel) << motion.v, turn.conjugate() * motion.w;
  for (int joint = 0; joint < model.nu; ++joint)
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

}  // namespace

walking::WholeBody nominal_body(Model on_floor) {
  const std::shared_ptr<const mjModel> model(std::move(on_floor));
  const std::shared_ptr<mjData> data(Data(mj_makeData(model.get())));
  return [=](const walking::BodyMotion& motion) { return momentum(*model, *data, motion); };
}

Eigen::VectorXd robot_positions(const mjModel& model, const walking::BodyPose& pose) {
  Eigen::VectorXd positions = Eigen::Map<const Eigen::VectorXd>(model.qpos0, model.nq);
  const Eigen::Quaterniond turn(pose.X_PB.linear());
  positions.head<7>() << pose.X_PB.translation(), turn.w(), turn.vec();
  for (int joint = 0; joint < model.nu; ++joint)
    positions[model.jnt_qposadr[model.actuator_trnid[2 * joint]]] = pose.q[joint];
  return positions;
}

}  // namespace sim::physics
