#include <iostream>

#include "sim/files/text.h"
#include "sim/regression/suite.h"
#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/options.h"
#include "walking/pattern_generator.h"

namespace cli {
namespace {

constexpr const char* kConfigExamples = R"(Examples:
  gaitslam config scenarios/tangent_circle.yaml slam.gyro.sigma_rad_s=0.02
  gaitslam config --keys)";

constexpr const char* kCheckExamples = R"(Examples:
  gaitslam check scenarios/hall.yaml scenarios/tangent_circle.yaml world.seed=7
Exit codes: 0 all scenarios are valid; 2 one is not.)";

struct ConfigRequest {
  std::string scenario;
  scenario::Changes changes;
  bool keys = false, yaml = false;
};

void print_row(const std::string& key, const std::string& value, std::string_view unit,
               const std::string& standard, const std::string& origin) {
  std::cout << fmt::format("{:<46} {:<12} {:<6} {:<10} {}\n", key, value, unit, standard, origin);
}

void print_values(const scenario::ReadScenario& read) {
  const auto origin = [&](const std::string& key) {
    const auto found = read.origin.find(key);
    return found == read.origin.end() ? "default" : found->second;
  };
  print_row("key", "value", "unit", "default", "from");
  for (const auto& key : scenario::scenario_keys()) {
    if (!scenario::has_section(read.scenario, key.name)) continue;
    const std::string value = key.print(read.scenario);
    if (value.find('\n') == value.npos) {
      print_row(key.name, value, scenario::unit_of(key.name).value_or(""),
                key.print(scenario::default_scenario()), origin(key.name));
      continue;
    }
    print_row(key.name, "", "", "", origin(key.name));  // a list is printed below, one item to a line
    for (const std::string& line : files::lines_of(value))
      if (line != "[") std::cout << line << '\n';
  }
  for (const scenario::MetricLimit& limit : read.scenario.limits.metrics) {
    const std::string key =
        fmt::format("limits.{}.{}", scenario::subject(limit), scenario::word(limit.bound));
    print_row(key, fmt::format("{}", limit.value), score::find_metric(limit.metric)->unit, "", origin(key));
  }
}

void print_keys() {
  std::cout
      << "base\n    another scenario file, relative to this one, or a list of them: what this one changes\n"
         "    a file or a list of files\n";
  for (const auto& key : scenario::scenario_keys()) {
    const std::string standard = key.print(scenario::default_scenario());
    const std::string shown = standard.find('\n') == standard.npos ? "; default " + standard : "";
    std::cout << fmt::format("{}\n    {}\n    {}{}\n", key.name, key.doc, key.expected, shown);
  }
  std::cout << "\nItems of walk.commands:\n"
            << scenario::describe<walking::Command>() << "\nItems of errors.faults:\n"
            << scenario::describe<sensor_errors::Fault>() << "\nItems of rig:\n"
            << scenario::describe<rig::Item>() << "\nItems of world.pushes and world.floor_patches:\n"
            << scenario::describe<physics::Push>() << scenario::describe<physics::FloorPatch>();
  std::cout << "\nlimits.<metric>.at_most, limits.<metric>.at_least; over seeds "
               "limits.<metric>.median.at_most (or mean, worst). Metrics:\n";
  for (const auto& metric : score::metric_definitions())
    std::cout << fmt::format("  {:<24} {:<4} {}\n", metric.name, metric.unit, metric.definition);
}

int config(ConfigRequest& request) {
  if (request.keys) {
    print_keys();
    return 0;
  }
  if (request.scenario.empty()) throw UsageError("config: expected a scenario's YAML file, or --keys");
  const scenario::ReadScenario read = scenario::read_scenario(request.scenario, request.changes);
  request.yaml ? void(std::cout << scenario::to_yaml(read.scenario)) : print_values(read);
  return 0;
}

struct CheckRequest {
  std::vector<std::string> files;  ///< and changes
  scenario::Changes changes;
  fs::path models = standard_models();
};

/// Reads the file and does all that a run does before the robot walks; prints the first error.
bool is_valid(const std::string& file, const scenario::Changes& changes, const fs::path& models) {
  try {
    const auto read = scenario::read_scenario(file, changes);
    require_models(read, models);
    const auto checked = check_start(read, models);
    const walking::PatternGenerator plan = checked ? *checked : walking::PatternGenerator(read.scenario.walk);
    std::cout << fmt::format(
        "{}: valid, a walk of {:.2f} s{}\n",
        read.origin.contains("name") ? file + ", " + read.scenario.name : file,
        static_cast<double>(plan.ticks()) * walking::kPeriod,
        checked ? "" : "; whether it is clear of its room was not checked: no simulator");
    return true;
  } catch (const scenario::ConfigError& e) {
    std::cerr << files::sanitize(e.what()) << '\n';
  } catch (const std::exception& e) {
    std::cerr << files::sanitize(fmt::format("{}: {}\n", file, e.what()));
  }
  return false;
}

/// Checks a scenario, or each one of a suite.
bool are_valid(const std::string& file, const CheckRequest& request) {
  std::vector<regression::SuiteEntry> entries;
  try {
    if (!regression::is_suite(file)) return is_valid(file, request.changes, request.models);
    entries = regression::read_suite(file).entries;
  } catch (const scenario::ConfigError& e) {
    std::cerr << files::sanitize(e.what()) << '\n';
    return false;
  }
  bool valid = true;
  for (const auto& entry : entries) {
    scenario::Changes all = entry.changes;
    std::ranges::copy(request.changes.overrides, std::back_inserter(all.overrides));
    std::ranges::copy(request.changes.without, std::back_inserter(all.without));
    all.with = request.changes.with;
    valid &= is_valid(entry.file.string(), all, request.models);
  }
  return valid;
}

int check(CheckRequest& request) {
  std::vector<std::string>& files = request.files;
  const auto is_file = [](const std::string& argument) {  // a change is as in world.seed=7
    const std::size_t equals = argument.find('=');
    return equals == argument.npos ||
           argument.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.") != equals;
  };
  const auto first_change = std::stable_partition(files.begin(), files.end(), is_file);
  request.changes.overrides.assign(first_change, files.end());
  files.erase(first_change, files.end());
  if (files.empty()) throw UsageError("check: names no scenario, expected a YAML file");
  int exit_code = 0;
  for (const std::string& file : files)
    if (!are_valid(file, request)) exit_code = 2;
  return exit_code;
}

}  // namespace

void add_config(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "config", "Print the value and origin of every key of a scenario",
                  kConfigExamples, config);
  add_scenario(command, request.scenario, request.changes);
  command.add_flag("--keys", request.keys, "list all keys with range, default and meaning");
  command.add_flag("--yaml", request.yaml, "print the whole scenario as YAML");
}

void add_check(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(app, exit_code, "check",
                                        "Check scenarios: do all that a run does before the robot walks, "
                                        "except starting a program",
                                        kCheckExamples, check);
  command
      .add_option("scenarios", request.files,
                  "YAML files of scenarios or suites, and keys with new values for all of them")
      ->option_text("FILE ... [key=value ...]")
      ->required();
  add_with(command, request.changes);
  add_without(command, request.changes);
  add_models(command, request.models);
}

}  // namespace cli
