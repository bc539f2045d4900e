#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>

#include "sim/regression/baseline.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/terminal.h"
#include "tools/cli/model_files.h"
#include "tools/cli/suite_run.h"
#include "tools/cli/usage_error.h"
#include "tools/cli/version.h"

namespace cli {
namespace {

namespace regression = sim::regression;

constexpr const char* kBaselineExamples = R"(
Examples:
  gaitslam baseline update --reason "the stabiliser damps the ankles" --jobs 2
  gaitslam baseline update scenarios/suites/ci.yaml --seeds 1..10 --reason "ten seeds"
  gaitslam baseline update --results results/regress-ci --reason "as the last regress had it"
Shows what changes, then writes the file. A result that misses a limit of its scenario is not written.
Exit codes: 0 written; 1 a limit is missed; 2 wrong usage or configuration; 3 a run failed.)";

struct BaselineRequest : SuiteRequest {
  std::string reason;
  bool dry_run = false;
};

/// Prints changes of the numbers of seeds, which the verdicts do not show.
void print_differences(const regression::Baseline& before, const SuiteRun& run) {
  for (const SuiteScenario& s : run.scenarios) {
    const regression::ScenarioResults* old = before.find(s.results.name);
    if (old && old->seeds.size() != run.seeds.size())
      std::cout << fmt::format("{}: {} seeds -> {}\n", s.results.name, old->seeds.size(), run.seeds.size());
  }
}

/// Compares with the old baseline whatever it was made of, and prints that.
regression::Comparison show(const regression::Baseline& before, const SuiteRun& run,
                            const BaselineRequest& request, const std::string& file) {
  const regression::Comparison comparison =
      compare_with(before.scenarios, run, request, "gaitslam baseline update: " + file + " before and after");
  std::cout << regression::verdict_table(comparison, colours());
  print_differences(before, run);
  return comparison;
}

/// The exit code by the limits alone: changes of metrics are what an update is for.
int limits_exit_code(std::vector<regression::ScenarioVerdict> verdicts) {
  for (regression::ScenarioVerdict& verdict : verdicts) verdict.metrics.clear();
  return regression::exit_code(verdicts);
}

int update(const BaselineRequest& request) {
  if (request.reason.find_first_not_of(" \t") == request.reason.npos)
    throw UsageError("--reason: is empty, expected the reason for the change");
  const std::string file = baseline_file(request).string();
  SuiteRun run = plan_suite(request);
  regression::Baseline baseline;
  if (std::filesystem::exists(file)) baseline = regression::read_baseline(file);
  run_suite(request, run);
  if (const int code = limits_exit_code(show(baseline, run, request, file).scenarios); code != 0) {
    std::cerr << fmt::format("gaitslam: {}: not changed, because a result misses a limit\n", file);
    return code;
  }
  if (request.dry_run) return 0;
  baseline.history.push_back({kRevision, request.reason, processor()});
  baseline.scenarios.clear();
  for (const SuiteScenario& s : run.scenarios) baseline.scenarios.push_back(s.results);
  regression::write_baseline(file, baseline);
  std::cout << "written to " << file << '\n';
  return 0;
}

}  // namespace

void add_baseline(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<BaselineRequest>();
  request->models = standard_models();
  CLI::App* baseline = app.add_subcommand("baseline", "Manage the results that a suite is compared with");
  baseline->require_subcommand(1);
  CLI::App* command = baseline->add_subcommand("update", "Run a suite and store its scores as the baseline");
  command->add_option("suite", request->suite, "the suite's YAML file")->capture_default_str();
  command->add_option("--reason", request->reason, "the reason for the change, stored in the baseline")
      ->required();
  add_suite_options(*command, *request);
  command->add_flag("--dry-run", request->dry_run, "show what would change and write nothing");
  command->footer(kBaselineExamples);
  baseline->footer(kBaselineExamples);
  command->callback([request, &exit_code] { exit_code = update(*request); });
}

}  // namespace cli
