// The simulator as the program sees it: there in the full build (live_world.cc), absent without
// (live_none.cc).
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <string>

#include "sim/bench/result.h"
#include "sim/bench/scenario.h"
#include "walking/whole_body.h"

namespace cli {

/// sim::bench::run, or UsageError in a build without the simulator.
sim::bench::Outcome run_live(const sim::bench::ReadScenario& scenario, const sim::bench::ResultPlace& place,
                             const sim::bench::Progress& progress);

/// Throws UsageError in a build without the simulator: asked before anything is begun.
void require_simulator();

/// The plan's model of the scenario's robot, or none without the simulator. Throws std::runtime_error when it
/// does not load.
walking::WholeBody whole_body(const sim::bench::Scenario& scenario, const std::filesystem::path& models);

/// Draws the robot in its room at a time, its waist where it truly was and its joints as the encoders read
/// them.
using RobotView = std::function<cv::Mat(slam::Stamp t, const Eigen::Isometry3d& X_WB)>;
/// Empty without the simulator. To be asked in order of time, by the thread that made it.
/// `recording`: the folder; throws FileError of its encoders.
RobotView robot_from_outside(const sim::bench::Scenario& scenario, const std::filesystem::path& recording,
                             const std::filesystem::path& models);

/// MuJoCo's version, or "" without the simulator.
std::string mujoco_version();

}  // namespace cli
