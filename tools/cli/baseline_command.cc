#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>

#include "sim/bench/baseline.h"
#include "tools/cli/commands.h"
#include "tools/cli/suite_run.h"
#include "tools/cli/version.h"

namespace cli {
namespace {

namespace bench = sim::bench;

constexpr const char* kExamples = R"(
Examples:
  gaitslam baseline update --reason "the stabiliser damps the ankles" --jobs 2
  gaitslam baseline update scenarios/suites/ci.yaml --seeds 1..10 --reason "ten seeds"
  gaitslam baseline update --results results/regress-ci --reason "as the last regress had it"
Shows what changes, then writes; --dry-run only shows. What misses a limit is not written.
Exit code: 0 written, 1 a limit is missed, 2 usage or configuration, 3 a run failed.)";

struct Request : SuiteRequest {
  std::string reason;
  bool dry_run = false;
};

/// What does not show in the verdicts.
void print_differences(const bench::Baseline& before, const SuiteRun& run) {
  for (const SuiteScenario& s : run.scenarios) {
    const bench::ScenarioResults* old = before.find(s.results.name);
    if (old && old->seeds.size() != run.seeds.size())
      std::cout << fmt::format("{}: {} seeds -> {}\n", s.results.name, old->seeds.size(), run.seeds.size());
  }
}

/// The old baseline is compared with, whatever it was made of; scenarios that the suite has no more go.
bench::Comparison show(const bench::Baseline& before, const SuiteRun& run, const Request& request,
                       const std::string& file) {
  const bench::Comparison comparison = compare_with(
      before.scenarios, run, request, "gaitslam baseline update: " + file + " as it is, and as it becomes");
  std::cout << bench::verdict_table(comparison, colours());
  print_differences(before, run);
  return comparison;
}

/// What the limits alone say: that a metric changes is what an update is for.
int limits_exit_code(std::vector<bench::ScenarioVerdict> verdicts) {
  for (bench::ScenarioVerdict& verdict : verdicts) verdict.metrics.clear();
  return bench::exit_code(verdicts);
}

int update(const Request& request) {
  if (request.reason.find_first_not_of(" \t") == request.reason.npos)
    throw UsageError("--reason: is empty, expected why the baseline changes");
  const std::string file = baseline_file(request).string();
  SuiteRun run = plan_suite(request);
  bench::Baseline baseline;
  if (std::filesystem::exists(file)) baseline = bench::read_baseline(file);
  run_suite(request, run);
  if (const int code = limits_exit_code(show(baseline, run, request, file).scenarios); code != 0) {
    std::cerr << fmt::format("gaitslam: {}: left as it is: a baseline keeps all limits\n", file);
    return code;
  }
  if (request.dry_run) return 0;
  baseline.history.push_back({kRevision, request.reason, processor()});
  baseline.scenarios.clear();
  for (const SuiteScenario& s : run.scenarios) baseline.scenarios.push_back(s.results);
  bench::write_baseline(file, baseline);
  std::cout << "written to " << file << '\n';
  return 0;
}

}  // namespace

void add_baseline(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  request->models = GAITSLAM_MODELS;
  CLI::App* baseline = app.add_subcommand("baseline", "What a suite is held against");
  baseline->require_subcommand(1);
  CLI::App* command =
      baseline->add_subcommand("update", "Run a suite and keep what it scores as its baseline");
  command->add_option("suite", request->suite, "the suite's YAML file")->capture_default_str();
  command->add_option("--reason", request->reason, "why, for those who read the baseline later")->required();
  add_suite_options(*command, *request);
  command->add_flag("--dry-run", request->dry_run, "show what would change, write nothing");
  command->footer(kExamples);
  baseline->footer(kExamples);
  command->callback([request, &exit_code] { exit_code = update(*request); });
}

}  // namespace cli
