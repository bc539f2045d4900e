// What a tuning is asked to do: one YAML file, read strictly.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/tune/recording_set.h"

namespace sim::tune {

/// A key of the scenario whose value is searched for, in a range that is scaled to [0, 1] by its logarithm or
/// linearly.
struct Parameter {
  std::string key;                ///< of the scenario
  std::vector<std::string> also;  ///< further keys that get the same value
  double low = 0, high = 1, start = 0;
  bool logarithmic = true;

  double value_at(double coordinate) const;  ///< coordinate in [0, 1]
  double coordinate_of(double value) const;  ///< clamped to [0, 1]
};

/// The loss that a tuning minimises, see Terms.
enum class Objective { pose_nll, innovation_nll, consistency, nis_consistency, rmse_m };
/// Its name in a spec, which is also the name of its value in a trial's record.
std::string_view name(Objective objective);

struct Spec {
  std::string name;  ///< the stem of the file's name
  std::vector<Parameter> parameters;
  std::vector<RecordingSet> training, holdout;
  Objective objective = Objective::pose_nll;
  int trials = 200;      ///< settings tried by the search, polish included
  int polish = 40;       ///< of them by Nelder and Mead's search, which starts at the best
  int population = 10;   ///< of a generation of CMA-ES
  bool profiles = true;  ///< whether the objective is profiled along each parameter
  int restarts = 2;      ///< most further polishes, each from a better setting that a profile found
  std::uint64_t seed = 1;
};

/// Reads a spec, whose paths are relative to its folder. Throws ConfigError ("file:line:column: key: ...") at
/// the first fault, FileError where a recording is missing.
Spec read_spec(const std::filesystem::path& file);

/// Sets a key of the scenario as a YAML file with that value would.
void set(scenario::Scenario& scenario, const std::string& key, double value);

}  // namespace sim::tune
