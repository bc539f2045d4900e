// The trials of a sweep as its page shows them, read from scores.jsonl.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace sim::pages {

/// One line of scores.jsonl.
struct SweepTrial {
  std::string scenario;
  std::vector<std::string> settings;  ///< the value of each key, as it is typed
  std::uint64_t seed = 0;
  std::string ending, cause;
  std::map<std::string, double> values;
};

/// The trials of one scenario.
struct ScenarioSweep {
  std::string scenario;
  std::vector<std::string> keys;
  std::vector<std::vector<std::string>> at;  ///< of each key, its values: numbers ascend, others as they came
  std::vector<std::map<std::string, std::size_t>> place;  ///< of each key, where its values are in `at`
  std::vector<SweepTrial> trials;
};

/// By scenario, in the order of the file. Throws files::FileError where there is no trial, or a line is
/// wrong.
std::vector<ScenarioSweep> read_sweep(const std::filesystem::path& folder);

/// The metrics that are shown of this sweep; the first one names the worst seeds.
std::vector<std::string> metrics_of(const ScenarioSweep& sweep);

/// The id in the page of the row of a setting, which has a value for each key.
std::string anchor(const ScenarioSweep& sweep, const std::vector<std::string>& settings);

/// Where the values of a key lie on an axis: at themselves where they are numbers, else at 1, 2, 3, ...
struct KeyAxis {
  std::vector<double> at;
  bool numbers = true, logarithmic = false;
};

KeyAxis axis_of_key(const std::vector<std::string>& values);

std::string with_unit(const std::string& key);      ///< "slam.vision.sigma_px [px]"
std::string metric_label(const std::string& name);  ///< "rmse_m [m]"

}  // namespace sim::pages
