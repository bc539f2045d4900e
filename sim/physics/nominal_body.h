// The plan's own model of the whole robot: momentum by multibody dynamics, of the model as it is. A pose of
// the robot as the positions of its model.
#pragma once

#include "sim/physics/model.h"
#include "walking/kinematics.h"
#include "walking/stabilizer.h"

namespace sim::physics {

/// The robot as the plan knows it: without the variations and disturbances of a run, the ankles' bushes at
/// rest. Copies share one state, so threads must not share them.
walking::WholeBody nominal_body(Model on_floor);

/// All positions (qpos) of the model with its robot in this pose and the ankles' bushes at rest.
Eigen::VectorXd robot_positions(const mjModel_& model, const walking::BodyPose& pose);

/// The load of each sole by the torques of its leg, for robots without force sensors at the ankles: computed
/// with the robot's nominal model, which no seed varies.
class LegLoads {
 public:
  LegLoads(Model on_floor, const walking::Robot& robot);

  /// Returns the wrench of the ground on the left and on the right foot: J^T f + tau = g(q) of the six joints
  /// of a leg, or the smallest such wrench if the leg has fewer. The waist counts as upright, and the links'
  /// inertia is neglected: while a leg swings that is some tens of N.
  std::array<walking::Wrench, 2> wrenches(const walking::JointVector& q,
                                          const walking::JointVector& torque) const;

 private:
  Model model_;
  Data data_;
  std::array<walking::Leg, 2> legs_;  // left, right
  std::array<int, 2> soles_;          // sites
};

}  // namespace sim::physics
