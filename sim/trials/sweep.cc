#include "sim/trials/sweep.h"

#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <set>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/scenario/keys.h"
#include "sim/trials/trial.h"
#include "sim/trials/values.h"

namespace sim::trials {
namespace {

using scenario::fail;
using scenario::Yaml;

using nlohmann::ordered_json;
using std::string_view_literals::operator""sv;

constexpr int kSamples = 16;

/// A key, and the values to try for it.
struct Tried {
  Yaml key;
  Values values;

  bool is_sampled() const {
    const auto* const range = std::get_if<Range>(&values);
    return range && range->points == 0;
  }
};

/// Throws ConfigError unless a sweep can set the key.
Tried read_tried(const Yaml& at, const Yaml& values) {
  const std::string& key = at.text;
  if (key == "seed") fail(at, key, "expected seeds (--seeds 1..5)");
  if (key == "name" || key.starts_with("limits."))
    fail(at, key, "does not affect runs, expected a key that does");
  if (!scenario::find_key(key)) fail(at, key, scenario::unknown_key(key));
  return {at, read_values(at, values)};
}

/// Reads the n-th argument (from 1): KEY=VALUE,VALUE or KEY=[VALUE, VALUE]. Brackets belong to a value if the
/// key expects a list.
Tried read_argument(const std::string& argument, int n) {
  const std::size_t equals = argument.find('=');
  Yaml key;
  key.kind = Yaml::Kind::scalar;
  key.text = argument.substr(0, equals);
  key.origin = {"<argument>", n, 1};
  if (equals == argument.npos)
    fail(key, "", "'{}': expected KEY=VALUE,VALUE; quote values with spaces", argument);
  const scenario::Origin origin{"<argument>", n, int(equals) + 1};  // the bracket is at the '='
  const Yaml values = scenario::parse_yaml("[" + argument.substr(equals + 1) + "]", origin);
  const auto* const known = scenario::find_key(key.text);
  const bool bracketed = known && known->expected.find("a list of") == std::string::npos &&
                         values.items.size() == 1 && values.items[0].is_list();
  return read_tried(key, bracketed ? values.items[0] : values);
}

/// Returns the settings for a value of the range.
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
  for (const auto& coordinates : sobol_points(std::size_t(samples), sampled.size())) {
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

std::vector<Axis> axes_of(const std::vector<Tried>& parameters, int samples) {
  std::vector<Axis> axes;
  std::vector<Tried> sampled;
  for (const Tried& tried : parameters)
    tried.is_sampled() ? sampled.push_back(tried) : axes.push_back(axis_of(tried));
  if (!sampled.empty()) axes.push_back(samples_of(sampled, samples));
  std::set<std::string> seen;
  for (const Axis& axis : axes)
    for (const Setting& setting : axis.front())
      if (!seen.insert(setting.key).second) fail(setting.at, setting.key, "has values twice");
  return axes;
}

/// Joins the lines of a printed list.
std::string on_one_line(const std::string& text) {
  std::string all;
  for (const std::string& line : files::lines_of(text))
    all += line.substr(std::min(line.size(), line.find_first_not_of(' ')));
  return all;
}

/// Returns the number of combinations of values. Throws ConfigError if there are too many trials.
std::size_t combinations(const SweepSpec& spec, std::size_t seeds) {
  double n = 1;
  for (const Axis& axis : spec.axes) n *= double(axis.size());
  const double trials = n * double(spec.scenarios.size() * seeds);
  if (trials <= kMostTrials) return std::size_t(n);
  const std::string why = fmt::format(
      "makes {:.0f} trials of {:.0f} combinations, {} scenarios and {} seeds, expected at most {}", trials, n,
      spec.scenarios.size(), seeds, kMostTrials);
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

/// Shortens the labels of estimators or controllers to their names if different values have different names.
void label_programs(SweepPlan& plan, const std::string& key, programs::Choice scenario::Scenario::*choice) {
  std::map<std::string, std::set<std::string>> values_of;
  const auto k = std::size_t(std::ranges::find(plan.keys, key) - plan.keys.begin());
  if (k == plan.keys.size()) return;
  for (const Configuration& one : plan.configurations)
    values_of[(one.read.scenario.*choice).name].insert(one.values[k]);
  if (std::ranges::any_of(values_of, [](const auto& name) { return name.second.size() > 1; })) return;
  for (Configuration& one : plan.configurations) one.labels[k] = (one.read.scenario.*choice).name;
}

/// Throws ConfigError if two scenarios have the same name, or if one lacks the section of a key.
void check_scenarios(const SweepSpec& spec, const scenario::Changes& changes) {
  std::map<std::string, fs::path> files;
  for (const fs::path& file : spec.scenarios) {
    const scenario::Scenario scenario = scenario::read_scenario(file, changes).scenario;
    const std::string& name = scenario.name;
    for (const Axis& axis : spec.axes)
      for (const Setting& setting : axis.front())
        if (!scenario::has_section(scenario, setting.key))
          fail(setting.at, setting.key, "{} has no such section", name);
    if (const auto [same, is_new] = files.emplace(name, file); !is_new)
      throw scenario::ConfigError(
          fmt::format("{}: has the same name as {}, '{}'; a sweep needs different names", file.string(),
                      same->second.string(), name));
  }
}

constexpr std::size_t kMostRows = 40;
constexpr std::array kShown{"ate_se3_rmse_m"sv, "rmse_m"sv, "nees_position_mean"sv, "nees_orientation_mean"sv,
                            "loop_landmarks"sv};

ordered_json value_of(const std::string& printed) {
  const ordered_json value = ordered_json::parse(printed, nullptr, false);
  return value.is_number() || value.is_boolean() ? value : ordered_json(printed);
}

}  // namespace

SweepSpec read_sweep(const fs::path& file, const std::vector<std::string>& arguments,
                     std::optional<int> samples) {
  const Yaml root = scenario::parse_yaml_file(file);
  const fs::path folder = file.parent_path();
  SweepSpec spec{file.stem().string(), {}, {}, {}};
  std::vector<Tried> parameters;
  std::optional<int> samples_of_file;
  const scenario::MapReaders readers{
      {"scenario", [&](const Yaml& value) { spec.scenarios = {read_path(value, "scenario", folder)}; }},
      {"scenarios",
       [&](const Yaml& list) {
         if (!list.is_list() || list.items.empty())
           fail(list, "scenarios", "expected a list of scenarios' YAML files");
         for (const Yaml& item : list.items) spec.scenarios.push_back(read_path(item, "scenarios", folder));
       }},
      {"seeds", [&](const Yaml& value) { spec.seeds = read_seeds(value); }},
      {"parameters",
       [&](const Yaml& map) {
         require_map(map, "parameters", "keys with values, as in {slam.vision.sigma_px: [1, 1.5, 2]}");
         for (const auto& [key, value] : map.entries()) parameters.push_back(read_tried(key, value));
       }},
      {"samples", [&](const Yaml& value) {
         scenario::read(value, "samples", {1, kMostTrials}, samples_of_file.emplace());
       }}};
  const bool is_sweep = std::ranges::any_of(readers, [&](const auto& reader) {
    return std::ranges::count(root.keys, reader.first, &Yaml::text) > 0;
  });
  if (is_sweep)
    read_map(root, readers);
  else
    spec.scenarios = {file};
  if (spec.scenarios.empty()) fail(root, "scenario", "missing, expected a scenario's YAML file");
  for (std::size_t i = 0; i < arguments.size(); ++i)
    parameters.push_back(read_argument(arguments[i], int(i) + 1));
  if ((samples || samples_of_file) && std::ranges::none_of(parameters, &Tried::is_sampled))
    throw scenario::ConfigError(fmt::format(
        "{}: samples: no parameter is a range without points, so there is nothing to sample", file.string()));
  spec.axes = axes_of(parameters, samples ? *samples : samples_of_file.value_or(kSamples));
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
  const std::size_t n = combinations(spec, seeds.size());
  check_scenarios(spec, changes);
  for (const fs::path& file : spec.scenarios)
    for (std::size_t i = 0; i < n; ++i) {
      scenario::Changes all = changes;
      for (const Point* point : points_of(spec, i))
        all.settings.insert(all.settings.end(), point->begin(), point->end());
      Configuration configuration{scenario::read_scenario(file, all), {}, {}};
      for (const std::string& key : plan.keys)
        configuration.values.push_back(
            on_one_line(scenario::find_key(key)->print(configuration.read.scenario)));
      configuration.labels = configuration.values;
      plan.configurations.push_back(std::move(configuration));
    }
  label_programs(plan, "estimator", &scenario::Scenario::estimator);
  label_programs(plan, "walk.controller", &scenario::Scenario::controller);
  return plan;
}

Scores scores(const SweepPlan& plan, const RecordOf& record) {
  std::vector<std::string> names;
  for (const auto& metric : score::metric_definitions()) names.emplace_back(metric.name);
  names.insert(names.end(), {"pose_nll", "innovation_nll"});
  Scores all{fmt::format("trial,scenario,seed{1}{0},ending,cause,{2}\n", fmt::join(plan.keys, ","),
                         plan.keys.empty() ? "" : ",", fmt::join(names, ",")),
             ""};
  for (std::size_t i = 0; i < plan.trials(); ++i) {
    const JobRecord* const one = record(i);
    if (!one) continue;
    const auto& [read, settings, labels] = plan.configurations[i / plan.seeds.size()];
    ordered_json line{{"trial", i}, {"scenario", read.scenario.name}, {"settings", ordered_json::object()}};
    all.csv += fmt::format("{},{},{}", i, files::neutral_field(read.scenario.name), one->seed);
    for (std::size_t k = 0; k < plan.keys.size(); ++k) {
      all.csv += "," + files::neutral_field(settings[k]);
      line["settings"][plan.keys[k]] = value_of(settings[k]);
      if (labels[k] != settings[k]) line["labels"][plan.keys[k]] = labels[k];
    }
    all.csv += fmt::format(",{},{}", one->ending, files::neutral_field(one->cause));
    for (const std::string& name : names) {
      const auto value = one->value(name);
      all.csv += value ? fmt::format(",{}", *value) : ",";
    }
    all.csv += "\n";
    line.update(ordered_json::parse(result::to_line(*one)));
    all.jsonl += files::json_text(line) + "\n";
  }
  return all;
}

std::string sweep_table(const SweepPlan& plan, const RecordOf& record) {
  std::vector<std::vector<std::string>> rows{{"scenario"}};
  rows[0].insert(rows[0].end(), plan.keys.begin(), plan.keys.end());
  rows[0].push_back("completed");
  rows[0].insert(rows[0].end(), kShown.begin(), kShown.end());
  for (std::size_t c = 0; c < std::min(plan.configurations.size(), kMostRows); ++c) {
    const Configuration& configuration = plan.configurations[c];
    int completed = 0;
    std::array<std::vector<double>, kShown.size()> shown;
    for (std::size_t i = 0; i < plan.seeds.size(); ++i) {
      const JobRecord* const one = record(c * plan.seeds.size() + i);
      completed += one && one->ending == "completed";
      for (std::size_t k = 0; k < kShown.size(); ++k)
        if (const auto value = one ? one->value(kShown[k]) : std::nullopt) shown[k].push_back(*value);
    }
    std::vector<std::string>& row = rows.emplace_back(configuration.labels);
    row.insert(row.begin(), configuration.read.scenario.name);
    row.push_back(fmt::format("{}/{}", completed, plan.seeds.size()));
    for (const std::vector<double>& values : shown)
      row.push_back(values.empty() ? "-" : fmt::format("{:.4g}", score::median(values)));
  }
  std::string text = files::text_table(rows, {.naming = 1 + plan.keys.size()});
  if (plan.configurations.size() > kMostRows)
    text += fmt::format("... and {} more\n", plan.configurations.size() - kMostRows);
  return plan.seeds.size() > 1 ? "medians over seeds\n" + text : text;
}

}  // namespace sim::trials
