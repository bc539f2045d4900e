#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <sstream>

#include "sim/scenario/keys.h"
#include "sim/scenario/limits.h"
#include "sim/scenario/lists.h"
#include "sim/score/metrics.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

namespace scenario = sim::scenario;

constexpr const char* kConfigExamples = R"(
Examples:
  gaitslam config scenarios/tangent_circle.yaml slam.gyro.sigma_rad_s=0.02
  gaitslam config scenarios/tangent_circle.yaml --yaml
  gaitslam config --keys)";

struct ConfigRequest {
  std::string scenario;
  scenario::Changes changes;
  bool keys = false, yaml = false;
};

void print_row(const std::string& key, const std::string& value, std::string_view unit,
               const std::string& standard, const std::string& origin) {
  std::cout << fmt::format("{:<46} {:<12} {:<6} {:<10} {}\n", key, value, unit, standard, origin);
}

/// Prints a list below its key, one item to a line.
void print_list(const std::string& key, const std::string& list, const std::string& origin) {
  print_row(key, "", "", "", origin);
  std::istringstream lines(list);
  for (std::string line; std::getline(lines, line);) {
    if (line != "[") std::cout << line << '\n';
  }
}

std::string origin_of(const scenario::ReadScenario& read, const std::string& key) {
  const auto found = read.origin.find(key);
  return found == read.origin.end() ? "default" : found->second;
}

void print_values(const scenario::ReadScenario& read) {
  print_row("key", "value", "unit", "default", "from");
  for (const auto& key : scenario::scenario_keys()) {
    if (!scenario::has_section(read.scenario, key.name)) continue;
    const std::string value = key.print(read.scenario), origin = origin_of(read, key.name);
    if (value.find('\n') != value.npos) {
      print_list(key.name, value, origin);
    } else {
      print_row(key.name, value, scenario::unit_of(key.name), key.print(scenario::default_scenario()),
                origin);
    }
  }
  for (const scenario::MetricLimit& limit : read.scenario.limits.metrics) {
    const std::string key =
        fmt::format("limits.{}.{}", scenario::subject(limit), scenario::word(limit.bound));
    print_row(key, fmt::format("{}", limit.value), sim::score::find_metric(limit.metric)->unit, "",
              origin_of(read, key));
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
  std::cout << "\nItems of walk.commands:\n" << scenario::describe_commands();
  std::cout << "\nItems of errors.faults:\n" << scenario::describe_faults();
  std::cout << "\nItems of world.pushes and world.floor_patches:\n" << scenario::describe_disturbances();
  std::cout << "\nlimits.<metric>.at_most, limits.<metric>.at_least; over seeds "
               "limits.<metric>.median.at_most (or mean, worst). Metrics:\n";
  for (const auto& metric : sim::score::metric_definitions()) {
    std::cout << fmt::format("  {:<24} {:<4} {}\n", metric.name, metric.unit, metric.definition);
  }
}

void config(const ConfigRequest& request) {
  if (request.keys) return print_keys();
  if (request.scenario.empty()) throw UsageError("config: expected a scenario's YAML file, or --keys");
  const scenario::ReadScenario read = scenario::read_scenario(request.scenario, request.changes);
  request.yaml ? void(std::cout << scenario::to_yaml(read.scenario)) : print_values(read);
}

}  // namespace

void add_config(CLI::App& app, int&) {
  auto request = std::make_shared<ConfigRequest>();
  CLI::App* command = app.add_subcommand("config", "Print the value and origin of every key of a scenario");
  add_scenario(*command, request->scenario, request->changes);
  command->add_flag("--keys", request->keys, "list all keys with range, default and meaning");
  command->add_flag("--yaml", request->yaml, "print the whole scenario as YAML");
  command->footer(kConfigExamples);
  command->callback([request] { config(*request); });
}

}  // namespace cli
