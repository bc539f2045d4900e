#include "sim/world/robot_positions.h"

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>

namespace sim::world {

Eigen::VectorXd robot_positions(const mjModel& model, const walking::BodyPose& pose) {
  Eigen::VectorXd positions = Eigen::Map<const Eigen::VectorXd>(model.qpos0, model.nq);
  const Eigen::Quaterniond turn(pose.X_PB.linear());
  positions.head<7>() << pose.X_PB.translation(), turn.w(), turn.vec();
  // The actuators are in the order of JointVector.
  for (int joint = 0; joint < walking::kJoints; ++joint)
    positions[model.jnt_qposadr[model.actuator_trnid[2 * joint]]] = pose.q[joint];
  return positions;
}

}  // namespace sim::world
