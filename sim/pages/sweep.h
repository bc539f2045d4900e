// The trials of a sweep, read from scores.jsonl, and the figures of its page.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sim/pages/figure.h"

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

/// By scenario, in the order of the file. Throws FileError if the file has no trial or a line is wrong.
std::vector<ScenarioSweep> read_sweep(const std::filesystem::path& folder);

/// The metrics that are shown of this sweep; the first one names the worst seeds.
std::vector<std::string> metrics_of(const ScenarioSweep& sweep);

/// The id in the page of the row of a setting, which has a value for each key.
std::string anchor(const ScenarioSweep& sweep, const std::vector<std::string>& settings);

/// Positions of the values of a key on an axis: numbers at themselves, others at 1, 2, 3, ...
struct KeyAxis {
  std::vector<double> at;
  bool numbers = true, logarithmic = false;
};

KeyAxis axis_of_key(const std::vector<std::string>& values);

std::string with_unit(const std::string& key);      ///< "slam.vision.sigma_px [px]"
std::string metric_label(const std::string& name);  ///< "rmse_m [m]"

/// Heat maps of pairs of keys and lines over one key, for each metric. Of many keys only the first have
/// figures, and of many trials only some are drawn as dots, so that the page of a large sweep can still be
/// opened.
std::vector<Figure> sweep_figures(const ScenarioSweep& sweep);
/// HTML that names the keys with figures if not all have them.
std::string about_left_out(const ScenarioSweep& sweep);

}  // namespace sim::pages
