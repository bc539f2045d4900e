// Contents of a scenario: walk, world, sensor errors, filter, and limits of the score.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
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

/// Direction of a limit.
enum class Bound { at_most, at_least };

/// Limit of a metric. aggregate: empty (for each run), or over seeds: "median", "mean", "worst".
struct MetricLimit {
  std::string metric, aggregate;
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

/// Everything that shapes a run. Without camera it has no frames, without slam no filter.
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
