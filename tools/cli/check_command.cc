#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "sim/files/text.h"
#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/model_files.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/usage_error.h"
#include "walking/pattern_generator.h"

namespace cli {
namespace {

constexpr const char* kCheckExamples = R"(
Examples:
  gaitslam check scenarios/*.yaml
  gaitslam check scenarios/hall.yaml scenarios/tangent_circle.yaml world.seed=7
Exit codes: 0 all scenarios are valid; 2 one is not.)";

/// Reads the file, plans its walk and checks its clearance; prints the first error.
bool is_valid(const std::string& file, const sim::scenario::Changes& changes) {
  try {
    const auto read = sim::scenario::read_scenario(file, changes);
    require_models(read, standard_models());
    const walking::PatternGenerator plan(read.scenario.walk, whole_body(read.scenario, standard_models()));
    const bool looked = require_clear_walk(read, standard_models());
    std::cout << fmt::format("{}: valid, a walk of {:.2f} s{}\n", file,
                             static_cast<double>(plan.ticks()) * walking::kPeriod,
                             looked ? "" : "; whether it is clear of its room was not checked: no simulator");
    return true;
  } catch (const sim::scenario::ConfigError& e) {
    std::cerr << sim::files::sanitize(e.what()) << '\n';
  } catch (const std::exception& e) {
    std::cerr << sim::files::sanitize(fmt::format("{}: the walk cannot be planned: {}\n", file, e.what()));
  }
  return false;
}

/// True for a change, as in world.seed=7; false for a file.
bool is_change(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  return equals != std::string::npos &&
         argument.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.") == equals;
}

int check(std::vector<std::string> files, sim::scenario::Changes changes) {
  const auto first_change = std::stable_partition(
      files.begin(), files.end(), [](const std::string& argument) { return !is_change(argument); });
  changes.overrides.assign(first_change, files.end());
  files.erase(first_change, files.end());
  if (files.empty()) throw UsageError("check: names no scenario, expected a YAML file");
  int exit_code = 0;
  for (const std::string& file : files)
    if (!is_valid(file, changes)) exit_code = 2;
  return exit_code;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
  auto files = std::make_shared<std::vector<std::string>>();
  auto changes = std::make_shared<sim::scenario::Changes>();
  CLI::App* command = app.add_subcommand("check",
                                         "Check scenarios: read them, plan their walks and look whether "
                                         "those are clear of their rooms, without simulating");
  command->add_option("scenarios", *files, "YAML files, and keys with new values for all of them")
      ->option_text("FILE ... [key=value ...]")
      ->required();
  add_with(*command, *changes);
  add_without(*command, *changes);
  command->footer(kCheckExamples);
  command->callback([files, changes, &exit_code] { exit_code = check(*files, *changes); });
}

}  // namespace cli
