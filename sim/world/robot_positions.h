// A pose of the robot as the positions of its model.
#pragma once

#include <Eigen/Core>

#include "walking/whole_body.h"

struct mjModel_;

namespace sim::world {

/// All positions (qpos) of the model with its robot in this pose and the ankles' bushes at rest.
Eigen::VectorXd robot_positions(const mjModel_& model, const walking::BodyPose& pose);

}  // namespace sim::world
