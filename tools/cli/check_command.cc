#include <iostream>

#include "sim/regression/suite.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

constexpr const char* kCheckExamples = R"(Examples:
  gaitslam check scenarios/hall.yaml scenarios/tangent_circle.yaml world.seed=7
Exit codes: 0 all scenarios are valid; 2 one is not.)";

struct CheckRequest {
  std::vector<std::string> files;  ///< files and, until check() separates them, changes
  scenario::Changes changes;
};

/// Reads the file and does everything that a run does before the robot walks.
void check_one(const std::string& file, const scenario::Changes& changes) {
  const auto read = scenario::read_scenario(file, changes);
  print_warnings(read);
  require_models(read, standard_models());
  const auto checked = check_start(read, standard_models());
  std::cout << fmt::format(
      "{}: valid{}\n", read.origin.contains("name") ? file + ", " + read.scenario.name : file,
      checked ? fmt::format(", a walk of {:.2f} s", double(checked->ticks()) * walking::kPeriod)
      : read.scenario.controller.source == programs::Source::program
          ? "; its walking controller started and answered READY"
          : "; not checked whether the robot can walk it: built without the simulator");
}

/// Returns whether `check` of a file throws nothing. Prints its error.
bool passes(const std::string& file, const std::function<void()>& check) {
  try {
    check();
    return true;
  } catch (const scenario::ConfigError& e) {
    std::cerr << files::sanitize(e.what()) << '\n';
  } catch (const std::exception& e) {
    std::cerr << files::sanitize(fmt::format("{}: {}\n", file, e.what()));
  }
  return false;
}

/// Checks a scenario, or each scenario of a suite.
bool are_valid(const std::string& file, const CheckRequest& request) {
  bool valid = true;
  return passes(file,
                [&] {
                  if (!regression::is_suite(file)) return check_one(file, request.changes);
                  for (const auto& entry : regression::read_suite(file).entries) {
                    scenario::Changes all = entry.changes;
                    std::ranges::copy(request.changes.overrides, std::back_inserter(all.overrides));
                    std::ranges::copy(request.changes.without, std::back_inserter(all.without));
                    all.with = request.changes.with;
                    valid &= passes(entry.file.string(), [&] { check_one(entry.file.string(), all); });
                  }
                }) &&
         valid;
}

int check(CheckRequest& request) {
  std::vector<std::string>& files = request.files;
  const auto is_file = [](const std::string& argument) {  // a change looks like world.seed=7
    const std::size_t equals = argument.find('=');
    return equals == argument.npos ||
           argument.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.") != equals;
  };
  const auto first_change = std::stable_partition(files.begin(), files.end(), is_file);
  request.changes.overrides.assign(first_change, files.end());
  files.erase(first_change, files.end());
  if (files.empty()) throw UsageError("check: no scenario given, expected a YAML file");
  int exit_code = 0;
  for (const std::string& file : files)
    if (!are_valid(file, request)) exit_code = 2;
  return exit_code;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "check",
                  "Check scenarios: do everything that a run does before the robot "
                  "walks. A walking controller is started for its READY, an estimator is not",
                  kCheckExamples, check);
  command
      .add_option("scenarios", request.files,
                  "YAML files of scenarios or suites, and key=value changes for all of them")
      ->option_text("FILE ... [key=value ...]")
      ->required();
  add_with(command, request.changes);
  add_without(command, request.changes);
}

}  // namespace cli
