// The plan's own model of the whole robot: its momentum by multibody dynamics, for the nominal model. Also
// converts a pose of the robot to positions of its model.
#pragma once

#include "sim/physics/model.h"
#include "walking/kinematics.h"
#include "walking/stabilizer.h"

namespace sim::physics {

/// The robot as known to the plan: without the variations and disturbances of a run, and with the ankles'
/// bushings at rest. Copies share one state, so threads must not share copies.
walking::WholeBody nominal_body(Model on_floor);

/// All positions (qpos) of the model with its robot in this pose and the ankles' bushings at rest.
Eigen::VectorXd robot_positions(const mjModel_& model, const walking::BodyPose& pose);

/// Estimates the load on each sole from the torques of its leg, for robots without force sensors at the
/// ankles. Uses the robot's nominal model, which does not vary with the seed.
class LegLoads {
 public:
  LegLoads(Model on_floor, const walking::Robot& robot);

  /// Returns the wrench of the ground on the left and the right foot: J^T f + tau = g(q) for the six joints
  /// of a leg, or the smallest such wrench if the leg has fewer. The waist is assumed to be upright, and the
  /// links' inertia is neglected; for a swinging leg that is a few tens of N.
  std::array<walking::Wrench, 2> wrenches(const walking::JointVector& q,
                                          const walking::JointVector& torque) const;

 private:
  Model model_;
  Data data_;
  std::array<walking::Leg, 2> legs_;  // left, right
  std::array<int, 2> soles_;          // sites
};

}  // namespace sim::physics
