// Reads robot.yaml: the parts of a robot's model by name, and the scenario defaults for that robot.
#pragma once

#include "sim/physics/robot_file.h"
#include "sim/scenario/options.h"
#include "sim/scenario/value.h"

namespace sim::scenario {

/// Returns the folder of the program's robots and rooms.
fs::path standard_models();

/// The folder of a robot: below models/robots, or a path if it has a slash.
fs::path robot_folder(const std::string& robot);

/// Throws ConfigError at the first key that is unknown, wrong or missing.
physics::RobotFile read_robot(const fs::path& folder);
/// Reads the robot of a scenario.
physics::RobotFile read_robot(const Scenario& scenario);

/// Returns the scenario keys that robot.yaml sets, with their values: keys below walk, stabilizer and slam,
/// and world.floor_friction. A scenario may override them, and the first value of a key counts: for the
/// sideways gait, that of walk_sideways. Empty if the file does not exist.
std::vector<std::pair<std::string, Yaml>> robot_defaults(const fs::path& folder, walking::Gait gait);

}  // namespace sim::scenario
