#include <iostream>

#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

constexpr const char* kConfigExamples = R"(Examples:
  gaitslam config scenarios/tangent_circle.yaml slam.gyro.sigma_rad_s=0.02
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
    print_row(key.name, "", "", "", origin(key.name));  // a list is printed below, one item per line
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
  std::cout << "base\n    the scenario file that this one modifies (relative path), or a list of files\n"
               "    a file or a list of files\n";
  for (const auto& key : scenario::scenario_keys()) {
    const std::string standard = key.print(scenario::default_scenario());
    const std::string shown = standard.find('\n') == standard.npos ? "; default " + standard : "";
    std::cout << fmt::format("{}\n    {}\n    {}{}\n", key.name, key.doc, key.expected, shown);
  }
  std::cout << "\nItems of walk.commands:\n"
            << scenario::describe<walking::Command>() << "\nItems of sessions:\n"
            << scenario::describe<scenario::Session>() << "\nItems of errors.faults:\n"
            << scenario::describe<sensor_errors::Fault>() << "\nItems of rig:\n"
            << scenario::describe<rig::Item>() << "\nItems of world.pushes and world.floor_patches:\n"
            << scenario::describe<physics::Push>() << scenario::describe<physics::FloorPatch>()
            << "\nItems of world.actors:\n"
            << scenario::describe<physics::Actor>();
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
  if (request.scenario.empty()) throw UsageError("config: no scenario given, expected a YAML file or --keys");
  const scenario::ReadScenario read = scenario::read_scenario(request.scenario, request.changes);
  request.yaml ? void(std::cout << scenario::to_yaml(read.scenario)) : print_values(read);
  return 0;
}

}  // namespace

void add_config(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "config", "Print the value and origin of every key of a scenario",
                  kConfigExamples, config);
  add_scenario(command, request.scenario, request.changes);
  command.add_flag("--keys", request.keys, "list all keys with meaning, range and default");
  command.add_flag("--yaml", request.yaml, "print the whole scenario as YAML");
}

}  // namespace cli
