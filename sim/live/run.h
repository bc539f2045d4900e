// The live loop: plan, stabilizer, physics, camera, recording and filter, one simulated millisecond at a
// time.
#pragma once

#include "sim/physics/world.h"
#include "sim/recording/recording.h"
#include "sim/result/result.h"
#include "sim/scenario/scenario.h"
#include "sim/tracking/tracking.h"
#include "walking/plan.h"
#include "walking/stabilizer.h"

namespace sim::live {

/// The robot and its plan when a frame is stamped.
struct StampedState {
  slam::Stamp t{0};
  const physics::World& world;
  const walking::Reference& plan;
  Eigen::Isometry3d X_PC;               ///< planned camera
  const recording::TrueFeet& feet;      ///< at the last tick
  const walking::Wrench &left, &right;  ///< ground on feet, at this tick
};

/// Callbacks of an observer; unused ones are empty.
struct RunObserver {
  std::function<void(const recording::RecordingSetup&)> begins = {};
  /// At the end of each tick of 5 ms. The walk continues when this returns.
  std::function<void(slam::Stamp)> ticked = {};
  std::function<void(const StampedState&)> stamped = {};
  /// Called some frames later, with the image, before the observation is processed. Returns whether `tracked`
  /// is called after it.
  std::function<bool(const slam::Observation& ideal)> wants = {};
  /// tracking: null without an estimator.
  std::function<void(const slam::Observation& ideal, const tracking::Tracking* tracking)> tracked = {};
};

/// Walks the scenario and leaves a complete result folder for any ending of the walk. place: the folders of
/// models and results. threads: 2 draws images in parallel with the walk; the result is the same, with or
/// without an observer. Throws std::invalid_argument or std::runtime_error if the scenario cannot be started
/// (a walk that cannot be planned, a model that does not load, a folder that cannot be written), and
/// ConfigError if the planned walk comes too close to its room. Then no folder is left behind.
result::Outcome run(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                    const result::Progress& progress, int threads = 1, const RunObserver& observer = {});

/// Does what run() does before the robot walks, but starts no program and writes nothing. Returns the
/// built-in controller's plan. Throws as run() does.
std::optional<walking::PatternGenerator> check(const scenario::ReadScenario& scenario,
                                               const std::filesystem::path& models);

/// Prints, line by line, the data read, the fraction of a leg's workspace that inverse kinematics reaches,
/// and the outcome of 5 s of standing and of steps in place. Returns whether all is well. For a robot that
/// cannot be read, throws std::runtime_error or std::invalid_argument with a one-line message.
bool check_robot(const std::filesystem::path& folder, const std::function<void(const std::string&)>& print);

/// Answers the messages of gaitslam_walker.h on standard input and output, using the pattern generator and
/// the stabilizer. Returns the exit code.
int run_plan_program();

}  // namespace sim::live
