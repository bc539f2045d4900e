// One scenario, one YAML file: the walk, the world, the sensors' errors, the filter, and the limits its score
// must keep.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/stream/sensor_errors.h"
#include "sim/world/options.h"
#include "slam/options.h"
#include "walking/plan.h"
#include "walking/stabilizer.h"

namespace sim::bench {

/// How a run can end. `failed`: the simulator or the filter broke in a way that no scenario can allow.
inline constexpr std::array<std::string_view, 5> kEndings{"completed", "fell", "collided", "diverged",
                                                          "failed"};

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
  std::vector<std::string> ending{"completed"};  ///< allowed endings, of kEndings
  std::vector<MetricLimit> metrics;
};

/// All that shapes a run, and nothing else does. Without camera there are no frames; without slam no filter
/// runs.
struct Scenario {
  std::string name;  ///< of the results folder; the file's stem unless the file says otherwise
  std::uint64_t seed = 1;
  walking::WalkOptions walk;
  walking::StabilizerOptions stabilizer;
  world::WorldOptions world;
  std::optional<world::CameraOptions> camera;
  stream::ErrorOptions errors;
  std::string estimator =
      "filter";  ///< one of estimator_names(); options other than the filter's are unused by others
  std::optional<slam::Options> slam;
  Limits limits;
};

/// A scenario and where each key that is not at its default was set ("file:line" or "argument 2").
struct ReadScenario {
  Scenario scenario;
  std::map<std::string, std::string, std::less<>> origin;
};

/// What is to be read besides the file: overlays in the order typed, which set some keys anew (as the
/// best.yaml of a tuning does), then overrides "key=value", then sections to leave out.
struct Changes {
  std::vector<std::string> overrides;
  std::vector<std::string> without;  ///< of "camera", "slam"
  std::vector<std::string> with{};   ///< YAML files
};

/// Reads a scenario strictly. Throws ConfigError (scenario_yaml.h) at the first thing that is not as it
/// should be.
ReadScenario read_scenario(const std::filesystem::path& file, const Changes& changes = {});

/// Likewise from text; file_name is what messages call it, its stem names the scenario.
ReadScenario read_scenario_text(std::string_view text, const std::string& file_name,
                                const Changes& changes = {});

/// The whole scenario as YAML; reading it again gives the same scenario bit for bit.
std::string to_yaml(const Scenario& scenario);

}  // namespace sim::bench
