#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>

#include "sim/bench/baseline.h"
#include "sim/bench/verdict_reports.h"
#include "sim/stream/durable_file.h"
#include "tools/cli/commands.h"
#include "tools/cli/suite_run.h"

namespace cli {
namespace {

namespace bench = sim::bench;

constexpr const char* kExamples = R"(
Examples:
  gaitslam regress scenarios/suites/ci.yaml --jobs 2
  gaitslam regress scenarios/suites/ci.yaml --baseline main.json --seeds 1..10 --junit junit.xml
  gaitslam regress scenarios/suites/ci.yaml slam.vision.sigma_px=2 --recordings results/regress-ci
Verdicts: IDENTICAL, the same bits on every seed; SAME, within tolerance; BETTER and FAIL, beyond it and
significant (signed rank test paired by seed, Holm over a scenario's gates, 5 %; under 8 seeds: on more than
half of the seeds and on none the other way); NOISY, beyond it yet maybe chance; NEW; MISSING fails too.
Exit code: 0 as good as the baseline, 1 worse or a limit missed, 2 usage, configuration or baseline, 3 a run
ended in a way that its scenario does not allow.)";

struct Request : SuiteRequest {
  std::optional<std::string> junit, markdown, json;
  bool github = false;
};

/// The baseline was made of these scenarios as their files have them, on at least these seeds.
void require_comparable(const bench::Baseline& baseline, const SuiteRun& run, const std::string& file) {
  for (const SuiteScenario& scenario : run.scenarios) {
    const std::string& name = scenario.read.scenario.name;
    const bench::ScenarioResults* before = baseline.find(name);
    if (!before) continue;
    if (bench::config_hash(before->config) != bench::config_hash(scenario.file_config)) {
      const auto differences = bench::compare(*before, {name, scenario.file_config, {}}, {}).other_config;
      throw UsageError(fmt::format(
          "{}: {} has another configuration than the baseline {}: {}; 'gaitslam baseline update' takes it in",
          scenario.entry.file.string(), name, file, fmt::join(differences, "; ")));
    }
    for (const std::uint64_t seed : run.seeds) {
      const auto has = [&](const bench::SeedScore& s) { return s.seed == seed; };
      if (std::none_of(before->seeds.begin(), before->seeds.end(), has))
        throw UsageError(fmt::format(
            "{}: has no seed {} of {}; 'gaitslam baseline update --seeds' adds seeds", file, seed, name));
    }
  }
}

void write(const Request& request, const bench::Comparison& comparison) {
  using sim::stream::write_durably;
  if (request.junit) write_durably(*request.junit, bench::junit(comparison));
  if (request.markdown) write_durably(*request.markdown, bench::markdown(comparison));
  if (request.json) write_durably(*request.json, bench::verdicts_json(comparison));
  if (!request.github) return;
  std::cout << bench::github_annotations(comparison);
  if (const char* summary = std::getenv("GITHUB_STEP_SUMMARY"))
    std::ofstream(summary, std::ios::app) << bench::markdown(comparison);
}

int regress(const Request& request) {
  const std::string file = baseline_file(request).string();
  SuiteRun run = plan_suite(request);
  const bench::Baseline baseline = bench::read_baseline(file);
  require_comparable(baseline, run, file);
  run_suite(request, run);
  const std::string title = fmt::format("gaitslam regress: suite {} against {} (revision {})", run.name, file,
                                        baseline.history.empty() ? "?" : baseline.history.back().revision);
  const bench::Comparison comparison = compare_with(baseline.scenarios, run, request, title);
  std::cout << bench::verdict_table(comparison, colours());
  write(request, comparison);
  return bench::exit_code(comparison.scenarios);
}

}  // namespace

void add_regress(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<Request>();
  request->models = GAITSLAM_MODELS;
  CLI::App* command = app.add_subcommand("regress", "Run a suite and hold it against a baseline");
  command->add_option("suite", request->suite, "the suite's YAML file")->required();
  command->add_option("changes", request->overrides, "what to set otherwise, in all scenarios")
      ->option_text("key=value ...");
  add_suite_options(*command, *request);
  command->add_option("--junit", request->junit, "write JUnit XML to a file");
  command->add_option("--markdown", request->markdown, "write a Markdown table to a file");
  command->add_option("--json", request->json, "write the verdicts as JSON to a file");
  command->add_flag("--github", request->github, "annotate a GitHub Actions log, and its job's summary");
  command->footer(kExamples);
  command->callback([request, &exit_code] { exit_code = regress(*request); });
}

}  // namespace cli
