#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml.h"
#include "tools/cli/commands.h"
#include "tools/cli/live.h"
#include "tools/cli/model_files.h"
#include "tools/cli/options.h"
#include "walking/pattern_generator.h"

namespace cli {
namespace {

constexpr const char* kCheckExamples = R"(
Examples:
  gaitslam check scenarios/*.yaml
Exit codes: 0 all scenarios are valid; 2 one is not.)";

/// Reads the file, plans its walk and looks whether that is clear of the room; prints the first fault.
bool is_valid(const std::string& file, const sim::scenario::Changes& changes) {
  try {
    const auto read = sim::scenario::read_scenario(file, changes);
    require_models(read, GAITSLAM_MODELS);
    const walking::PatternGenerator plan(read.scenario.walk, whole_body(read.scenario, GAITSLAM_MODELS));
    const bool looked = require_clear_walk(read, GAITSLAM_MODELS);
    std::cout << fmt::format("{}: valid, a walk of {:.2f} s{}\n", file,
                             static_cast<double>(plan.ticks()) * walking::kPeriod,
                             looked ? "" : "; whether it is clear of its room was not checked: no simulator");
    return true;
  } catch (const sim::scenario::ConfigError& e) {
    std::cerr << e.what() << '\n';
  } catch (const std::exception& e) {
    std::cerr << fmt::format("{}: the walk cannot be planned: {}\n", file, e.what());
  }
  return false;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
  auto files = std::make_shared<std::vector<std::string>>();
  auto changes = std::make_shared<sim::scenario::Changes>();
  CLI::App* command = app.add_subcommand("check",
                                         "Check scenarios: read them, plan their walks and look whether "
                                         "those are clear of their rooms, without simulating");
  command->add_option("scenarios", *files, "YAML files")->required();
  add_with(*command, *changes);
  command->footer(kCheckExamples);
  command->callback([files, changes, &exit_code] {
    for (const std::string& file : *files) exit_code = is_valid(file, *changes) ? exit_code : 2;
  });
}

}  // namespace cli
