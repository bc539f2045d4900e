// The contents of a scenario: walk, world, sensor errors, filter, and limits on the score.
#pragma once

#include <span>

#include "sim/camera/options.h"
#include "sim/physics/options.h"
#include "sim/programs/choice.h"
#include "sim/sensor_errors/sensor_errors.h"
#include "slam/options.h"
#include "walking/plan.h"
#include "walking/stabilizer.h"

namespace sim::scenario {

/// stopped: a steered walk had no estimate for too long, or a command took twice its time. estimator_failed,
/// walker_failed: the estimator or the walking controller crashed, missed a time limit or gave an invalid
/// answer. sensor_unused: the filter did not use one of its sensors in any frame. failed: the simulator
/// broke, which no scenario can allow. crashed, not_started: the run's process left no result.
enum class Ending {
  completed,
  fell,
  collided,
  diverged,
  stopped,
  estimator_failed,
  walker_failed,
  sensor_unused,
  failed,
  crashed,
  not_started
};

/// In the order of the enumerators.
inline constexpr std::array<std::string_view, 11> kEndings{
    "completed",     "fell",          "collided", "diverged", "stopped",    "estimator_failed",
    "walker_failed", "sensor_unused", "failed",   "crashed",  "not started"};

/// The names of the endings that a result can have.
inline constexpr auto kResultEndings = std::span(kEndings).first<9>();

constexpr std::string_view name_of(Ending ending) { return kEndings[std::size_t(ending)]; }

/// Returns the exit code of a run if its scenario does not allow the ending.
constexpr int exit_code_of(Ending ending) { return ending == Ending::not_started ? 2 : 3; }

/// Returns the ending of this name, or nullopt.
constexpr std::optional<Ending> ending_named(std::string_view name) {
  const auto found = std::ranges::find(kEndings, name);
  if (found == kEndings.end()) return std::nullopt;
  return static_cast<Ending>(found - kEndings.begin());
}

/// An ending and its cause in words; a completed run has none.
struct Ended {
  Ending ending = Ending::not_started;
  std::string cause = {};
};

/// The direction of a limit.
enum class Bound { at_most, at_least };

/// A limit on a metric. aggregate: over seeds ("median", "mean", "worst"); absent: for each run.
struct MetricLimit {
  std::string metric;
  std::optional<std::string> aggregate;
  Bound bound = Bound::at_most;
  double value = 0;
  bool operator==(const MetricLimit&) const = default;
};

/// The scenario's keys limits.*: conditions for a run to pass.
struct Limits {
  std::vector<std::string> ending{"completed"};  ///< names of Endings
  std::vector<MetricLimit> metrics;

  static void keys(auto&& key) { choice<&Limits::ending>(key, kResultEndings, "endings of a run that pass"); }
};

/// How much simulated time an answer of the estimator takes.
enum class TimeModel { none, fixed, measured };
inline constexpr std::array<std::string_view, 3> kTimeModels{"none", "fixed", "measured"};

/// The treatment of frames that arrive when the estimator is busy and the queue is full.
enum class OnBusy { drop, wait };
inline constexpr std::array<std::string_view, 2> kOnBusy{"drop", "wait"};

/// The scenario's keys estimator.time.*: when the answer to a frame takes effect.
struct EstimatorTime {
  TimeModel model = TimeModel::none;
  double frame_ms = 0;
  int queue = 0;
  OnBusy on_busy = OnBusy::drop;

  static void keys(auto&& key) {
    choice<&EstimatorTime::model>(
        key, kTimeModels,
        "simulated time that each answer takes: none, fixed (frame_ms), or measured (its wall time, so the "
        "run is not repeatable)");
    number<&EstimatorTime::frame_ms>(key, 0, 1e6, "simulated time of each answer, with model: fixed");
    number<&EstimatorTime::queue>(
        key, 0, 1, "number of frames that wait for a busy estimator; a newer frame replaces the waiting one");
    choice<&EstimatorTime::on_busy>(
        key, kOnBusy,
        "treatment of further frames while the estimator is busy: drop (their images; IMU readings go "
        "with the next frame), or wait in turn");
  }
};

/// The names of the built-in walking controllers. "plan" is the pattern generator with its stabilizer.
inline constexpr std::array<std::string_view, 1> kControllers{"plan"};

/// The scenario's keys walk.controller.time.*: when an answer of the walking controller takes effect.
struct ControllerTime {
  TimeModel model = TimeModel::none;
  double answer_ms = 0;

  static void keys(auto&& key) {
    choice<&ControllerTime::model>(
        key, kTimeModels,
        "simulated time that each answer of the program takes: none, fixed (answer_ms), or measured (its "
        "wall time, so the run is not repeatable)");
    number<&ControllerTime::answer_ms>(
        key, 0, 1000, "simulated time from the sensors to the servos' commands, with model: fixed");
  }
};

/// A session before the scenario's own: it is the same scenario with some other keys.
struct Session {
  static constexpr const char* kName = "session";
  std::vector<std::string> set;

  static void keys(auto&& key) {
    value<&Session::set>(
        key, "keys that differ in this session, as in [world.light.level=0.3, world.start.x_m=1]");
  }
};

/// Everything that affects a run. A run without `camera` has no frames, and without `slam` no filter.
struct Scenario {
  std::string name;
  std::uint64_t seed = 1;
  walking::WalkOptions walk;
  programs::Choice controller{.name = "plan"};
  ControllerTime controller_time;
  walking::StabilizerOptions stabilizer;
  physics::WorldOptions world;
  std::optional<camera::CameraOptions> camera;
  rig::ImuOptions imu;
  std::vector<rig::Item> rig;  ///< further sensors
  sensor_errors::ErrorOptions errors;
  programs::Choice estimator{.name = "filter"};  ///< only the filter uses the section slam
  EstimatorTime estimator_time;
  std::optional<slam::Options> slam;
  std::vector<Session> sessions;  ///< before this one
  Limits limits;

  static void keys(auto&& key) {
    value<&Scenario::name>(key, "name of the results folder; default: the scenario file's name");
    value<&Scenario::seed>(key, "seed of every random stream of the run");
    key.choice("walk.controller", &Scenario::controller, kControllers,
               "what makes the robot walk: plan (pattern generator and stabilizer), or an external program");
    part<&Scenario::walk>(key);
    key.part("walk.controller.time", &Scenario::controller_time);
    part<&Scenario::stabilizer, &Scenario::world, &Scenario::camera, &Scenario::imu>(key);
    value<&Scenario::rig>(
        key,
        "additional sensors, which the filter does not use: a preset (head_2006, d435i, d435i_848 "
        "or d435i_mid360) or a list of sensors and presets");
    part<&Scenario::errors>(key);
    value<&Scenario::estimator>(key,
                                "estimator of the run: a built-in one by its name, or an external program");
    key.part("estimator.time", &Scenario::estimator_time);
    part<&Scenario::slam>(key);
    value<&Scenario::sessions>(key,
                               "sessions before this one, walked by the same robot with other noise: each "
                               "loads the map of the previous session, and this session loads the last one");
    part<&Scenario::limits>(key);
  }
};

}  // namespace sim::scenario
