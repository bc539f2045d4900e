// Short walks of the built-in controller in each direction, without cameras: how well a robot walks.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/live/leg_noises.h"
#include "sim/physics/model.h"
#include "sim/physics/robot.h"
#include "sim/scenario/scenario.h"

namespace sim::live {

/// Commands, and what they do in words: "ahead".
struct ShortWalk {
  std::string name;
  std::vector<walking::Command> commands;
};

/// Returns walks of 8 s ahead, back, to both sides and turning on the spot, in steps of the robot's length.
std::vector<ShortWalk> short_walks(const walking::WalkOptions& options);

/// How a walk went, compared with its commands.
struct Walked {
  std::string problem;            ///< why it cannot be planned or how it ended; empty if it was completed
  double lasted = 0;              ///< fraction of the walk
  std::array<int, 2> landings{};  ///< how often the left and the right foot have left the floor and landed
  double limited = 0;             ///< fraction of the ticks with a leg's torque at its limit
  double path_m = 0,
         error_m = 0;  ///< distance from start to end of the commands, and from there to the robot
  double turn_rad = 0, yaw_error_rad = 0;  ///< of the commands; of the robot from their end
  double slip_m = 0;  ///< sum of the ways of the soles while each carries the robot alone
  LegNoises noises;   ///< of completed walks

  /// Returns what is wrong in words: the problem, or a heading or place too far from the end of the commands
  /// (15 degrees; 10 % of the path, at least 0.05 m). Empty if the robot arrived.
  std::string complaint() const;
};

/// Walks the scenario's robot with the walk and stabilizer of the scenario. seed: of the plant's variation;
/// without it, the plant is the nominal model.
Walked walked(const scenario::Scenario& scenario, const physics::Models& models,
              std::vector<walking::Command> commands, std::optional<std::uint64_t> seed);

}  // namespace sim::live
