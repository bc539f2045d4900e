// All that a scenario sets: the walk, the world, the sensors' errors, the filter, and the limits its score
// must keep.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/camera/options.h"
#include "sim/estimators/estimator_choice.h"
#include "sim/physics/options.h"
#include "sim/scenario/ending.h"
#include "sim/sensor_errors/sensor_errors.h"
#include "slam/options.h"
#include "walking/plan.h"
#include "walking/stabilizer.h"

namespace sim::scenario {

/// Which way a limit holds its metric.
enum class Bound { at_most, at_least };

/// What a metric must keep. aggregate: empty (each run on its own), or over seeds: "median", "mean", "worst".
struct MetricLimit {
  std::string metric, aggregate;
  Bound bound = Bound::at_most;
  double value = 0;
  bool operator==(const MetricLimit&) const = default;
};

/// The scenario's keys limits.*: what a run must keep to pass.
struct Limits {
  std::vector<std::string> ending{"completed"};  ///< names of Endings
  std::vector<MetricLimit> metrics;

  static void keys(auto&& key) { choice<&Limits::ending>(key, kResultEndings, "endings of a run that pass"); }
};

/// All that shapes a run, and nothing else does. Without camera there are no frames; without slam no filter
/// runs.
struct Scenario {
  std::string name;
  std::uint64_t seed = 1;
  walking::WalkOptions walk;
  walking::StabilizerOptions stabilizer;
  physics::WorldOptions world;
  std::optional<camera::CameraOptions> camera;
  sensor_errors::ErrorOptions errors;
  estimators::EstimatorChoice estimator;  ///< the section slam is unused by all but the filter
  std::optional<slam::Options> slam;
  Limits limits;

  static void keys(auto&& key) {
    value<&Scenario::name>(key, "name of the results folder; without it, that of the scenario's file");
    value<&Scenario::seed>(key, "seed of every random stream of the run");
    part<&Scenario::walk>(key);
    part<&Scenario::stabilizer>(key);
    part<&Scenario::world>(key);
    part<&Scenario::camera>(key);
    part<&Scenario::errors>(key);
    value<&Scenario::estimator>(key,
                                "estimator of the run: a built-in one by its name, or an external program");
    part<&Scenario::slam>(key);
    part<&Scenario::limits>(key);
  }
};

}  // namespace sim::scenario
