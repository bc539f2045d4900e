// Reads a robot from its compiled model and its file, once.
#pragma once

#include "sim/physics/robot_file.h"

struct mjModel_;

namespace sim::physics {

/// Throws std::invalid_argument with one line, "file:line:column: key: what is wrong, expected ..." for what
/// robot.yaml names, or with the element of the model.
walking::Robot read_robot(const mjModel_& model, const RobotFile& file);

}  // namespace sim::physics
