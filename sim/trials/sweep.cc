#include "sim/trials/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

#include "sim/scenario/keys.h"
#include "sim/scenario/value.h"
#include "sim/scenario/yaml_map.h"
#include "sim/trials/values.h"

namespace sim::trials {
namespace {

namespace fs = std::filesystem;
using scenario::fail;
using scenario::Yaml;

constexpr int kSamples = 16;

/// A key, and what is tried of it.
struct Tried {
  Yaml key;
  Values values;
};

/// Throws ConfigError unless a sweep can set the key.
void require_key(const Yaml& at, const std::string& key) {
  if (key == "seed") fail(at, key, "expected seeds (--seeds 1..5)");
  if (key == "name" || key.starts_with("limits."))
    fail(at, key, "does not change a run, expected a key that does");
  if (!scenario::find_key(key)) fail(at, key, scenario::unknown_key(key));
}

Tried read_tried(const Yaml& key, const Yaml& values) {
  require_key(key, key.text);
  return {key, read_values(key, values)};
}

std::vector<Tried> read_all_tried(const Yaml& map) {
  require_map(map, "parameters", "keys with values, as in {slam.vision.sigma_px: [1, 1.5, 2]}");
  std::vector<Tried> all;
  for (std::size_t k = 0; k < map.keys.size(); ++k) all.push_back(read_tried(map.keys[k], map.items[k]));
  return all;
}

/// Reads the n-th argument, from 1: KEY=VALUES, the values being those of a YAML list.
Tried read_argument(const std::string& argument, int n) {
  const std::size_t equals = argument.find('=');
  Yaml key;
  key.kind = Yaml::Kind::scalar;
  key.text = argument.substr(0, equals);
  key.origin = {"<argument>", n, 1};
  if (equals == argument.npos) fail(key, "", fmt::format("'{}': expected KEY=VALUE,VALUE", argument));
  require_key(key, key.text);
  const scenario::Origin origin{"<argument>", n, static_cast<int>(equals) + 1};  // the bracket is at the '='
  return read_tried(key, scenario::parse_yaml("[" + argument.substr(equals + 1) + "]", origin));
}

/// The settings that a value of the range makes.
Point point_of(const Yaml& key, const Range& range, double value) {
  const Yaml node = number_node(value, key.origin, true);
  Point point{{range.key, key, node}};
  for (const std::string& also : range.also) point.push_back({also, key, node});
  return point;
}

Axis axis_of(const Tried& tried) {
  Axis axis;
  if (const auto* const range = std::get_if<Range>(&tried.values))
    for (const double value : range->grid()) axis.push_back(point_of(tried.key, *range, value));
  else
    for (const Yaml& value : std::get<0>(tried.values)) axis.push_back({{tried.key.text, tried.key, value}});
  return axis;
}

Axis samples_of(const std::vector<Tried>& sampled, int samples) {
  Axis axis;
  for (const auto& coordinates : sobol_points(static_cast<std::size_t>(samples), sampled.size())) {
    Point all;
    for (std::size_t d = 0; d < sampled.size(); ++d) {
      const Range& range = std::get<Range>(sampled[d].values);
      const Point one = point_of(sampled[d].key, range, range.value_at(coordinates[d]));
      all.insert(all.end(), one.begin(), one.end());
    }
    axis.push_back(std::move(all));
  }
  return axis;
}

/// Throws ConfigError at the key that makes too many combinations.
void add_axis(std::vector<Axis>& axes, Axis axis) {
  const Setting& first = axis.front().front();
  std::size_t n = axis.size();
  for (const Axis& before : axes) n *= before.size();
  if (n > kMostTrials)
    fail(first.at, first.key, fmt::format("makes {} combinations, expected at most {}", n, kMostTrials));
  axes.push_back(std::move(axis));
}

std::vector<Axis> axes_of(const std::vector<Tried>& parameters, int samples) {
  std::vector<Axis> axes;
  std::vector<Tried> sampled;
  for (const Tried& tried : parameters) {
    const auto* const range = std::get_if<Range>(&tried.values);
    if (range && range->points == 0)
      sampled.push_back(tried);
    else
      add_axis(axes, axis_of(tried));
  }
  if (!sampled.empty()) add_axis(axes, samples_of(sampled, samples));
  return axes;
}

void require_each_key_once(const SweepSpec& spec) {
  std::vector<std::string> seen;
  for (const Axis& axis : spec.axes)
    for (const Setting& setting : axis.front()) {
      if (std::find(seen.begin(), seen.end(), setting.key) != seen.end())
        fail(setting.at, setting.key, "is given values twice");
      seen.push_back(setting.key);
    }
}

std::vector<fs::path> scenario_files(const Yaml& list, const fs::path& folder) {
  if (list.kind != Yaml::Kind::list || list.items.empty())
    fail(list, "scenarios", "expected a list of scenarios' YAML files");
  std::vector<fs::path> files;
  for (const Yaml& item : list.items) files.push_back(read_path(item, "scenarios", folder));
  return files;
}

bool has_any_key(const Yaml& root, const scenario::MapReaders& readers) {
  return std::any_of(root.keys.begin(), root.keys.end(), [&](const Yaml& key) {
    return std::any_of(readers.begin(), readers.end(), [&](const auto& r) { return r.first == key.text; });
  });
}

void apply(const Setting& setting, scenario::ReadScenario& read) {
  if (!scenario::has_section(read.scenario, setting.key))
    fail(setting.at, setting.key, fmt::format("{} has no such section", read.scenario.name));
  scenario::find_key(setting.key)->read(setting.value, read.scenario);
  read.origin[setting.key] = fmt::format("{}:{}", setting.value.origin.file, setting.value.origin.line);
}

/// Joins the lines of a printed list.
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
  fail(last.at, last.key, why);
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
      throw scenario::ConfigError(fmt::format(
          "{}: has the same name as {}, '{}'; a sweep needs different names", spec.scenarios[i].string(),
          spec.scenarios[same->second].string(), scenarios[i].scenario.name));
  }
}

}  // namespace

SweepSpec read_sweep(const fs::path& file, const std::vector<std::string>& arguments,
                     std::optional<int> samples) {
  const Yaml root = scenario::parse_yaml_file(file);
  const fs::path folder = file.parent_path();
  SweepSpec spec{file.stem().string(), {}, {}, {}};
  std::vector<Tried> parameters;
  int samples_of_file = kSamples;
  const scenario::MapReaders readers{
      {"scenario", [&](const Yaml& value) { spec.scenarios = {read_path(value, "scenario", folder)}; }},
      {"scenarios", [&](const Yaml& value) { spec.scenarios = scenario_files(value, folder); }},
      {"seeds", [&](const Yaml& value) { spec.seeds = read_seeds(value); }},
      {"parameters", [&](const Yaml& value) { parameters = read_all_tried(value); }},
      {"samples", [&](const Yaml& value) {
         scenario::read(value, "samples", {1, kMostTrials}, samples_of_file);
       }}};
  if (has_any_key(root, readers))
    read_map(root, readers);
  else
    spec.scenarios = {file};
  if (spec.scenarios.empty()) fail(root, "scenario", "missing, expected a scenario's YAML file");
  for (std::size_t i = 0; i < arguments.size(); ++i)
    parameters.push_back(read_argument(arguments[i], static_cast<int>(i) + 1));
  spec.axes = axes_of(parameters, samples.value_or(samples_of_file));
  require_each_key_once(spec);
  return spec;
}

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
  std::vector<scenario::ReadScenario> scenarios;
  for (const auto& file : spec.scenarios) scenarios.push_back(scenario::read_scenario(file, changes));
  require_different_names(scenarios, spec);
  for (const scenario::ReadScenario& scenario : scenarios)
    for (std::size_t i = 0; i < combinations(spec); ++i) {
      Configuration configuration{scenario, {}};
      for (const Point* point : points_of(spec, i))
        for (const Setting& setting : *point) apply(setting, configuration.read);
      for (const std::string& key : plan.keys)
        configuration.values.push_back(
            on_one_line(scenario::find_key(key)->print(configuration.read.scenario)));
      plan.configurations.push_back(std::move(configuration));
    }
  return plan;
}

}  // namespace sim::trials
