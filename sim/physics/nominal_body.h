// The plan's own model of the whole robot: momentum by multibody dynamics, of the model as it is. A pose of
// the robot as the positions of its model.
#pragma once

#include "sim/physics/model.h"
#include "walking/kinematics.h"

namespace sim::physics {

/// The robot as the plan knows it: without the variations and disturbances of a run, the ankles' bushes at
/// rest. Copies share one state, so threads must not share them.
walking::WholeBody nominal_body(Model on_floor);

/// All positions (qpos) of the model with its robot in this pose and the ankles' bushes at rest.
Eigen::VectorXd robot_positions(const mjModel_& model, const walking::BodyPose& pose);

}  // namespace sim::physics
