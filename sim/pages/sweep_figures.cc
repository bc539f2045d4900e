#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "sim/pages/html.h"
#include "sim/pages/sweep.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

constexpr std::size_t kMostMappedKeys = 6;  // 15 heat maps of each metric
constexpr std::size_t kMostLineKeys = 20;   // a figure of each metric
constexpr std::size_t kMostDots = 2000;     // of a figure

bool is_counted(const std::string& name) { return name == "loop_landmarks"; }

/// True if the key has few values, as in a grid, and not one for each sample.
bool is_grid(const ScenarioSweep& sweep, std::size_t k) { return sweep.at[k].size() <= 20; }

/// Selects the trials that have a dot. Multiples of the golden ratio are spread evenly modulo 1, and
/// so are those of every second, third, ... number: no value of a grid is left out.
bool is_drawn(std::size_t n, std::size_t trials) {
  const double multiple = std::numbers::phi * static_cast<double>(n);
  return trials <= kMostDots ||
         multiple - std::floor(multiple) < static_cast<double>(kMostDots) / static_cast<double>(trials);
}

Figure lines_figure(const ScenarioSweep& sweep, std::size_t k, const std::string& metric) {
  const KeyAxis axis = axis_of_key(sweep.at[k]);
  Figure f{fmt::format("{}_{}_{}", sweep.scenario, metric, sweep.keys[k]),
           fmt::format("{} over {}", metric, sweep.keys[k]),
           axis.numbers ? with_unit(sweep.keys[k]) : sweep.keys[k] + ", by the order of its values below",
           metric_label(metric)};
  f.logarithmic_x = axis.logarithmic, f.whole_x = !axis.numbers, f.whole_y = is_counted(metric);
  std::vector<std::vector<double>> values(axis.at.size());
  Line dots{"a trial", Role::truth, {}, {}, true}, median{"median", Role::estimate};
  for (std::size_t n = 0; n < sweep.trials.size(); ++n) {
    const SweepTrial& trial = sweep.trials[n];
    const auto value = trial.values.find(metric);
    if (value == trial.values.end()) continue;
    const std::size_t i = sweep.place[k].at(trial.settings[k]);
    values[i].push_back(value->second);
    if (is_drawn(n, sweep.trials.size())) dots.x.push_back(axis.at[i]), dots.y.push_back(value->second);
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i].empty()) continue;
    median.x.push_back(axis.at[i]), median.y.push_back(score::median(values[i]));
  }
  if (sweep.trials.size() > kMostDots) {
    dots.name = fmt::format("{} of {} trials", dots.x.size(), sweep.trials.size());
    median.name = "median of all";
  }
  f.lines = {dots};
  if (is_grid(sweep, k)) f.lines.push_back(median);
  return f;
}

Figure heat_figure(const ScenarioSweep& sweep, std::size_t a, std::size_t b, const std::string& metric) {
  Figure f{fmt::format("{}_{}_{}_{}", sweep.scenario, metric, sweep.keys[a], sweep.keys[b]),
           fmt::format("{}: median over {}; dark is worse", metric_label(metric),
                       sweep.keys.size() > 2 ? "seeds and the other keys" : "seeds"),
           with_unit(sweep.keys[a]), with_unit(sweep.keys[b])};
  f.columns = sweep.at[a], f.rows = sweep.at[b];
  struct Cell {
    std::string href;  // of its first trial
    std::vector<double> values;
  };
  std::map<std::pair<std::size_t, std::size_t>, Cell> cells;
  for (const SweepTrial& trial : sweep.trials) {
    Cell& cell = cells[{sweep.place[a].at(trial.settings[a]), sweep.place[b].at(trial.settings[b])}];
    if (cell.href.empty()) cell.href = "#" + anchor(sweep, trial.settings);
    if (const auto v = trial.values.find(metric); v != trial.values.end()) cell.values.push_back(v->second);
  }
  for (const auto& [at, cell] : cells) {
    const double value = cell.values.empty() ? NAN : score::median(cell.values);
    f.cells.push_back(
        {at.first, at.second, value, score::loss(value, score::direction_of(metric)), cell.href});
  }
  return f;
}

/// The keys that have several values.
std::vector<std::size_t> varied_keys(const ScenarioSweep& sweep) {
  std::vector<std::size_t> keys;
  for (std::size_t k = 0; k < sweep.keys.size(); ++k)
    if (sweep.at[k].size() > 1) keys.push_back(k);
  return keys;
}

/// The varied keys of a grid.
std::vector<std::size_t> grid_keys(const ScenarioSweep& sweep) {
  std::vector<std::size_t> keys = varied_keys(sweep);
  std::erase_if(keys, [&](std::size_t k) { return !is_grid(sweep, k); });
  return keys;
}

std::vector<std::size_t> first(std::vector<std::size_t> keys, std::size_t most) {
  keys.resize(std::min(keys.size(), most));
  return keys;
}

/// Lists the keys with figures if not all have them. what: the figures.
std::string about_left_out(const ScenarioSweep& sweep, const std::string& what,
                           const std::vector<std::size_t>& keys, std::size_t most) {
  if (keys.size() <= most) return "";
  std::string names;
  for (const std::size_t k : first(keys, most)) names += (names.empty() ? "" : ", ") + escaped(sweep.keys[k]);
  return fmt::format("<p>{} are drawn of the first {} of {} keys with several values: {}.</p>\n", what, most,
                     keys.size(), names);
}

}  // namespace

std::string about_left_out(const ScenarioSweep& sweep) {
  return about_left_out(sweep, "Heat maps", grid_keys(sweep), kMostMappedKeys) +
         about_left_out(sweep, "Lines and dots", varied_keys(sweep), kMostLineKeys);
}

std::vector<Figure> sweep_figures(const ScenarioSweep& sweep) {
  std::vector<Figure> all;
  const std::vector<std::size_t> mapped = first(grid_keys(sweep), kMostMappedKeys),
                                 lined = first(varied_keys(sweep), kMostLineKeys);
  for (const std::string& metric : metrics_of(sweep)) {
    const std::size_t before = all.size();
    for (std::size_t a = 0; a < mapped.size(); ++a)
      for (std::size_t b = a + 1; b < mapped.size(); ++b)
        all.push_back(heat_figure(sweep, mapped[a], mapped[b], metric));
    if (sweep.keys.size() == 2 && all.size() > before) continue;  // it has both keys already
    for (const std::size_t k : lined) all.push_back(lines_figure(sweep, k, metric));
  }
  return all;
}

}  // namespace sim::pages
