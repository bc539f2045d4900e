#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "sim/bench/scenario.h"
#include "sim/bench/scenario_yaml.h"
#include "tools/cli/commands.h"
#include "tools/cli/live.h"
#include "walking/pattern_generator.h"

namespace cli {
namespace {

constexpr const char* kExamples = R"(
Examples:
  gaitslam check scenarios/*.yaml
Exit code: 0 all are fine, 2 one is not.)";

/// Reads the file and plans its walk; prints what is wrong with it.
bool is_fine(const std::string& file, const sim::bench::Changes& changes) {
  try {
    const auto read = sim::bench::read_scenario(file, changes);
    const walking::PatternGenerator plan(read.scenario.walk, whole_body(read.scenario, GAITSLAM_MODELS));
    std::cout << fmt::format("{}: fine, a walk of {:.2f} s\n", file,
                             static_cast<double>(plan.ticks()) * walking::kPeriod);
    return true;
  } catch (const sim::bench::ConfigError& e) {
    std::cerr << e.what() << '\n';
  } catch (const std::exception& e) {
    std::cerr << fmt::format("{}: the walk cannot be planned: {}\n", file, e.what());
  }
  return false;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
  auto files = std::make_shared<std::vector<std::string>>();
  auto changes = std::make_shared<sim::bench::Changes>();
  CLI::App* command =
      app.add_subcommand("check", "Read scenarios strictly and plan their walks; simulate nothing");
  command->add_option("scenarios", *files, "YAML files")->required();
  add_with(command, *changes);
  command->footer(kExamples);
  command->callback([files, changes, &exit_code] {
    for (const std::string& file : *files) exit_code = is_fine(file, *changes) ? exit_code : 2;
  });
}

}  // namespace cli
