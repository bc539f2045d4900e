// The plan's own model of the whole robot: momentum by multibody dynamics, of the model file as it is. A pose
// of the robot as the positions of its model.
#pragma once

#include "sim/physics/model.h"
#include "walking/kinematics.h"

namespace sim::physics {
/// models/<robot>.xml as the plan knows it: without the variations and disturbances of a run, the ankles'
/// bushings at rest. Copies share one state, so threads must not share them.
///
/// Throws std::runtime_error if the model does not load, or if a link, joint, sole or sensor mount is not
/// that of the nominal robot.
walking::WholeBody nominal_body(const std::string& robot, const std::filesystem::path& models);
walking::WholeBody nominal_body(Model on_floor);

/// All positions (qpos) of the model with its robot in this pose and the ankles' bushes at rest.
Eigen::VectorXd robot_positions(const mjModel_& model, const walking::BodyPose& pose);

}  // namespace sim::physics
