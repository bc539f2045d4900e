#include "sim/tune/sweep_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

#include "sim/scenario/keys.h"
#include "sim/tune/value_list.h"

namespace sim::tune {
namespace {

void apply(const Setting& setting, scenario::ReadScenario& read) {
  if (!scenario::has_section(read.scenario, setting.key))
    scenario::fail(setting.at, setting.key, fmt::format("{} has no such section", read.scenario.name));
  scenario::find_key(setting.key)->read(setting.value, read.scenario);
  read.origin[setting.key] = fmt::format("{}:{}", setting.value.origin.file, setting.value.origin.line);
}

/// A list's lines as one.
std::string on_one_line(const std::string& text) {
  std::string line;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n')
      i = std::min(text.find_first_not_of("\n ", i), text.size()) - 1;
    else
      line += text[i];
  }
  return line;
}

std::vector<std::string> printed(const std::vector<std::string>& keys, const scenario::Scenario& scenario) {
  std::vector<std::string> values;
  for (const std::string& key : keys) values.push_back(on_one_line(scenario::find_key(key)->print(scenario)));
  return values;
}

std::size_t combinations(const SweepSpec& spec) {
  std::size_t n = 1;
  for (const Axis& axis : spec.axes) n *= axis.size();
  return n;
}

void require_few_trials(const SweepSpec& spec, std::size_t seeds) {
  const std::size_t n = combinations(spec), scenarios = spec.scenarios.size(), trials = n * scenarios * seeds;
  if (trials <= kMostTrials) return;
  const std::string why =
      fmt::format("makes {} trials of {} combinations, {} scenarios and {} seeds, expected at most {}",
                  trials, n, scenarios, seeds, kMostTrials);
  if (spec.axes.empty()) throw scenario::ConfigError(fmt::format("{}: {}", spec.name, why));
  const Setting& last = spec.axes.back().front().front();
  scenario::fail(last.at, last.key, why);
}

/// The points of one combination; the last axis changes fastest.
std::vector<const Point*> points_of(const SweepSpec& spec, std::size_t combination) {
  std::vector<const Point*> points(spec.axes.size());
  for (std::size_t a = spec.axes.size(); a-- > 0;) {
    points[a] = &spec.axes[a][combination % spec.axes[a].size()];
    combination /= spec.axes[a].size();
  }
  return points;
}

void require_different_names(const std::vector<scenario::ReadScenario>& scenarios, const SweepSpec& spec) {
  std::map<std::string_view, std::size_t> first;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    const auto [same, is_new] = first.emplace(scenarios[i].scenario.name, i);
    if (!is_new)
      throw scenario::ConfigError(fmt::format("{}: is called '{}' as {} is; a sweep needs names that differ",
                                              spec.scenarios[i].string(), scenarios[i].scenario.name,
                                              spec.scenarios[same->second].string()));
  }
}

}  // namespace

scenario::ReadScenario SweepPlan::scenario(std::size_t trial) const {
  scenario::ReadScenario read = configurations[trial / seeds.size()].read;
  read.scenario.seed = seeds[trial % seeds.size()];
  return read;
}

SweepPlan plan_sweep(const SweepSpec& spec, const std::vector<std::uint64_t>& seeds,
                     const scenario::Changes& changes) {
  SweepPlan plan{spec.name, {}, {}, seeds};
  for (const Axis& axis : spec.axes)
    for (const Setting& setting : axis.front()) plan.keys.push_back(setting.key);
  require_few_trials(spec, seeds.size());
  const std::size_t n = combinations(spec);
  std::vector<scenario::ReadScenario> scenarios;
  for (const auto& file : spec.scenarios) scenarios.push_back(scenario::read_scenario(file, changes));
  require_different_names(scenarios, spec);
  for (const scenario::ReadScenario& scenario : scenarios)
    for (std::size_t i = 0; i < n; ++i) {
      Configuration configuration{scenario, {}};
      for (const Point* point : points_of(spec, i))
        for (const Setting& setting : *point) apply(setting, configuration.read);
      configuration.values = printed(plan.keys, configuration.read.scenario);
      plan.configurations.push_back(std::move(configuration));
    }
  return plan;
}

}  // namespace sim::tune
