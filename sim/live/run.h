// The live loop: plan, stabilizer, physics, camera, recording and filter, one simulated millisecond after
// another.
#pragma once

#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/result/result.h"
#include "sim/scenario/scenario.h"
#include "sim/tracking/tracking.h"
#include "walking/plan.h"
#include "walking/stabilizer.h"

namespace sim::live {

/// Robot and plan when a frame is stamped.
struct StampedState {
  slam::Stamp t{0};
  const physics::World& world;
  const walking::Reference& plan;
  Eigen::Isometry3d X_PC;               ///< planned camera
  const recording::TrueFeet& feet;      ///< of the last tick
  const walking::Wrench &left, &right;  ///< of the ground on the feet, at this tick
};

/// Callbacks of an observer; unused ones are empty.
struct RunObserver {
  std::function<void(const recording::RecordingSetup&)> begins = {};
  /// At the end of each tick of 5 ms; the walk continues when it returns.
  std::function<void(slam::Stamp)> ticked = {};
  std::function<void(const StampedState&)> stamped = {};
  tracking::TrackingObserver tracking = {};  ///< some frames later, with the image
};

/// Walks the scenario and leaves a complete result folder, whatever the ending.
/// place: where models lie and results go. threads: 2 draws images beside the walk; the result is the same,
/// and so it is with any observer. Throws std::invalid_argument or std::runtime_error when the scenario
/// cannot be started (a walk that cannot be planned, a model that does not load, a folder that cannot be
/// written) and ConfigError when the planned walk is not clear of its room; then no folder is left behind.
result::Outcome run(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                    const result::Progress& progress, int threads = 1, const RunObserver& observer = {});

/// Does what run() does before the robot walks, but starts no program and writes nothing. Returns the plan of
/// the built-in controller. Throws as run().
std::optional<walking::PatternGenerator> check(const scenario::ReadScenario& scenario,
                                               const std::filesystem::path& models);

/// Prints line by line what was read, the share of a leg's workspace that inverse kinematics reaches, and how
/// 5 s of standing and steps in place end. Returns whether all is well. Throws std::runtime_error or
/// std::invalid_argument with one line for a robot that cannot be read.
bool check_robot(const std::filesystem::path& folder, const std::function<void(const std::string&)>& print);

/// Answers the messages of gaitslam_walker.h on standard input and output by pattern generator and
/// stabilizer. Returns the exit code.
int run_plan_program();

}  // namespace sim::live
