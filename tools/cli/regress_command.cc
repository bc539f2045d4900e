#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <fstream>
#include <memory>

#include "sim/files/text.h"
#include "sim/regression/baseline.h"
#include "sim/regression/verdict_reports.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/terminal.h"
#include "tools/cli/model_files.h"
#include "tools/cli/options.h"
#include "tools/cli/suite_run.h"
#include "tools/cli/verdict_files.h"

namespace cli {
namespace {

namespace regression = sim::regression;
namespace result = sim::result;

constexpr const char* kRegressExamples = R"(
Examples:
  gaitslam regress scenarios/suites/ci.yaml --jobs 2
  gaitslam regress scenarios/suites/ci.yaml --baseline main.json --seeds 1..10 --junit junit.xml
  gaitslam regress scenarios/suites/ci.yaml slam.vision.sigma_px=2 --recordings results/regress-ci
Verdicts:
  IDENTICAL  the same bits on every seed
  SAME       within the tolerance
  BETTER     better by more than the tolerance, and significantly
  FAIL       worse by more than the tolerance, and significantly
  NOISY      beyond the tolerance, but possibly by chance
  NEW        the baseline does not have it
  MISSING    the baseline has it and the results do not; counts as a failure
Significance is decided by the signed rank test paired by seed, with Holm's correction over the gates of a scenario,
at 5 %. With fewer than 8 seeds more than half of them must be beyond the tolerance and none in the other direction.
Exit codes: 0 as good as the baseline; 1 worse, or a limit missed; 2 wrong usage, configuration or baseline; 3 a run
ended in a way that its scenario does not allow.)";

struct RegressRequest : SuiteRequest {
  VerdictFiles files;
  bool github = false;
};

/// Throws UsageError unless the baseline was made of the same scenarios and of all seeds of the run.
void require_comparable(const regression::Baseline& baseline, const SuiteRun& run, const std::string& file) {
  for (const SuiteScenario& scenario : run.scenarios) {
    const std::string& name = scenario.read.scenario.name;
    const regression::ScenarioResults* before = baseline.find(name);
    if (!before) continue;
    if (regression::config_hash(before->config) != regression::config_hash(scenario.file_config)) {
      const auto differences =
          regression::compare(*before, {name, scenario.file_config, {}}, {}).other_config;
      throw UsageError(
          fmt::format("{}: {} has another configuration than the baseline {}: {}; run 'gaitslam baseline "
                      "update' to store it",
                      scenario.entry.file.string(), name, file, fmt::join(differences, "; ")));
    }
    for (const std::uint64_t seed : run.seeds) {
      const auto has = [&](const result::SeedScore& s) { return s.seed == seed; };
      if (std::none_of(before->seeds.begin(), before->seeds.end(), has))
        throw UsageError(
            fmt::format("{}: has no seed {} of {}; run 'gaitslam baseline update --seeds' to add seeds", file,
                        seed, name));
    }
  }
}

void write(const RegressRequest& request, const regression::Comparison& comparison) {
  report_verdicts(comparison, request.files);
  if (!request.github) return;
  text_out() << regression::github_annotations(comparison);
  const char* const summary = std::getenv("GITHUB_STEP_SUMMARY");
  if (!summary) return;
  std::ofstream out(summary, std::ios::app);
  out << regression::markdown(comparison);
  out.close();
  if (!out) throw sim::files::FileError(summary, "cannot be written");
}

int regress(const RegressRequest& request) {
  request.files.require_replaceable();
  const std::string file = baseline_file(request).string();
  SuiteRun run = plan_suite(request);
  const regression::Baseline baseline = regression::read_baseline(file);
  require_comparable(baseline, run, file);
  run_suite(request, run);
  const std::string title = fmt::format("gaitslam regress: suite {} against {} (revision {})", run.name, file,
                                        baseline.history.empty() ? "?" : baseline.history.back().revision);
  const regression::Comparison comparison = compare_with(baseline.scenarios, run, request, title);
  write(request, comparison);
  return regression::exit_code(comparison.scenarios);
}

}  // namespace

void add_regress(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<RegressRequest>();
  request->models = standard_models();
  CLI::App* command = app.add_subcommand("regress", "Run a suite and compare it with its baseline");
  command->add_option("suite", request->suite, "the suite's YAML file")->required();
  add_overrides(*command, request->overrides, "in all scenarios");
  add_suite_options(*command, *request);
  add_verdict_files(*command, request->files);
  command->add_flag("--github", request->github, "annotate the log and the summary of a GitHub Actions job");
  command->footer(kRegressExamples);
  command->callback([request, &exit_code] { exit_code = regress(*request); });
}

}  // namespace cli
