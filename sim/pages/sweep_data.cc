#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/pages/sweep.h"
#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"

namespace sim::pages {
namespace {

namespace fs = std::filesystem;
using files::Json;

// Shown if the sweep has them.
constexpr std::array kMetrics{"ate_se3_rmse_m", "rmse_m", "end_position_error_m", "nees_position_mean",
                              "loop_landmarks"};

std::string typed(const Json& value) {
  return value.value().is_string() ? value.text() : files::json_text(value.value());
}

SweepTrial trial_of(const Json& line, std::vector<std::string>& keys) {
  SweepTrial trial{line.at("scenario").text(), {}, line.at("seed").whole(), line.at("ending").text(), "", {}};
  if (const auto cause = line.find("cause")) trial.cause = cause->text();
  std::vector<std::string> names;
  for (const auto& [key, value] : line.at("settings").entries()) {
    names.push_back(key);
    trial.settings.push_back(typed(value));
  }
  if (keys.empty()) keys = names;
  if (keys != names) line.at("settings").fail("has other keys than the lines before");
  for (const auto& [name, value] : line.at("values").entries())
    if (value.value().is_number()) trial.values[name] = value.number();
  return trial;
}

/// Numbers in ascending order; other values in the order of the file.
std::vector<std::string> ordered(std::vector<std::string> values) {
  const auto number = [](const std::string& v) { return files::parse_number<double>(v); };
  if (std::all_of(values.begin(), values.end(), [&](const auto& v) { return number(v).has_value(); }))
    std::stable_sort(values.begin(), values.end(),
                     [&](const auto& a, const auto& b) { return *number(a) < *number(b); });
  return values;
}

void find_values(ScenarioSweep& sweep) {
  for (std::size_t k = 0; k < sweep.keys.size(); ++k) {
    std::vector<std::string> values;
    std::map<std::string, std::size_t> place;
    for (const SweepTrial& trial : sweep.trials)
      if (place.emplace(trial.settings[k], 0).second) values.push_back(trial.settings[k]);
    sweep.at.push_back(ordered(std::move(values)));
    for (std::size_t i = 0; i < sweep.at[k].size(); ++i) place[sweep.at[k][i]] = i;
    sweep.place.push_back(std::move(place));
  }
}

bool has(const ScenarioSweep& sweep, const std::string& metric) {
  return std::any_of(sweep.trials.begin(), sweep.trials.end(),
                     [&](const SweepTrial& trial) { return trial.values.contains(metric); });
}

}  // namespace

std::vector<ScenarioSweep> read_sweep(const fs::path& folder) {
  const fs::path file = folder / "scores.jsonl";
  std::istringstream text(files::read_text(file));
  std::vector<ScenarioSweep> all;
  std::vector<std::string> keys;
  for (std::string line; std::getline(text, line);) {
    SweepTrial trial = trial_of(Json(file, line), keys);
    auto found = std::find_if(all.begin(), all.end(),
                              [&](const ScenarioSweep& s) { return s.scenario == trial.scenario; });
    if (found == all.end()) found = all.insert(all.end(), {trial.scenario, {}, {}, {}, {}});
    found->trials.push_back(std::move(trial));
  }
  if (all.empty()) throw files::FileError(file, "has no trial");
  for (ScenarioSweep& sweep : all) {
    sweep.keys = keys;
    find_values(sweep);
  }
  return all;
}

std::vector<std::string> metrics_of(const ScenarioSweep& sweep) {
  std::vector<std::string> shown;
  for (const char* metric : kMetrics)
    if (has(sweep, metric)) shown.emplace_back(metric);
  return shown;
}

std::string anchor(const ScenarioSweep& sweep, const std::vector<std::string>& settings) {
  std::string name = "setting-" + sweep.scenario;
  for (std::size_t k = 0; k < settings.size(); ++k)
    name += fmt::format("-{}", sweep.place[k].at(settings[k]) + 1);
  return name;
}

KeyAxis axis_of_key(const std::vector<std::string>& values) {
  KeyAxis axis;
  for (const std::string& value : values) {
    const auto number = files::parse_number<double>(value);
    axis.numbers = axis.numbers && number.has_value();
    axis.at.push_back(number.value_or(0));
  }
  if (!axis.numbers)
    for (std::size_t i = 0; i < values.size(); ++i) axis.at[i] = static_cast<double>(i + 1);
  axis.logarithmic = axis.numbers && axis.at.front() > 0 && axis.at.back() > 8 * axis.at.front();
  return axis;
}

std::string with_unit(const std::string& key) {
  const std::string unit(scenario::unit_of(key));
  return unit.empty() ? key : fmt::format("{} [{}]", key, unit);
}

std::string metric_label(const std::string& name) {
  const score::MetricDefinition* defined = score::find_metric(name);
  return defined && defined->unit != "1" ? fmt::format("{} [{}]", name, defined->unit) : name;
}

}  // namespace sim::pages
