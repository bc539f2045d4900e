#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <fstream>
#include <iostream>

#include "sim/files/text.h"
#include "sim/regression/suite.h"
#include "sim/result/result.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/jobs/verdicts.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

constexpr const char* kRegressExamples = R"(Examples:
  gaitslam regress scenarios/suites/ci.yaml --baseline main.json --seeds 1..10 --junit junit.xml
  gaitslam regress scenarios/suites/ci.yaml slam.vision.sigma_px=2 --cached
Verdicts: IDENTICAL, the same bits on every seed; SAME, within the tolerance; BETTER or FAIL, beyond the tolerance and
significantly; NOISY, beyond it, but possibly by chance; NEW or MISSING (a failure), only one of the sides has it.
Significance is decided by the signed rank test paired by seed, with Holm's correction over the gates of a scenario,
at 5 %. With fewer than 8 seeds more than half of them must be beyond the tolerance and none in the other direction.
Exit codes: 0 as good as the baseline; 1 worse, or a limit missed; 2 wrong usage, configuration or baseline; 3 a run
ended in a way that its scenario does not allow.)";

constexpr const char* kBaselineExamples = R"(Examples:
  gaitslam baseline update --reason "the stabilizer damps the ankles" --jobs 2
  gaitslam baseline update --results results/regress-ci --reason "as the last regress had it"
Shows what changes, then writes the file. Results that miss a limit of their scenario are not written.
Exit codes: 0 written; 1 a limit is missed; 2 wrong usage or configuration; 3 a run failed.)";

/// The options of all commands on suites.
struct SuiteRequest : OutRequest {
  fs::path suite = "scenarios/suites/ci.yaml";
  std::vector<std::string> overrides;
  std::optional<std::string> seeds, baseline;
  std::optional<fs::path> results;  ///< <scenario>/seed-<n> to judge instead of running
  fs::path models = standard_models();
  Backend backend;
  bool cached = false;
};

/// One scenario of a suite and the results of its runs.
struct SuiteScenario {
  regression::SuiteEntry entry;
  scenario::ReadScenario read;
  regression::ScenarioResults results{};
};

struct SuiteRun {
  std::string name;
  std::vector<std::uint64_t> seeds;
  std::vector<SuiteScenario> scenarios;
};

void add_suite_options(CLI::App& command, SuiteRequest& request) {
  command.add_option("--baseline", request.baseline, "instead of ../baselines/<suite>.json");
  add_seeds(command, request.seeds, "seeds instead of those of the suite");
  add_backend_options(command, request.backend);
  command.add_option("--results", request.results, "judge DIR/<scenario>/seed-<n>, run nothing");
  add_cached(command, request.cached);
  add_out(command, request);
  add_models(command, request.models);
}

/// The file of the baseline: --baseline, else <suite>.json in baselines/ beside the folder of the suite.
fs::path baseline_file(const SuiteRequest& request) {
  if (request.baseline) return *request.baseline;
  return (request.suite.parent_path() / ".." / "baselines" / request.suite.stem())
             .lexically_normal()
             .string() +
         ".json";
}

SuiteRun plan_suite(const SuiteRequest& request) {
  const regression::Suite suite = regression::read_suite(request.suite);
  for (const std::string& change : request.overrides)
    if (change.starts_with("seed=") || change.starts_with("name="))
      throw UsageError(change + ": a suite has its own names and seeds, expected --seeds");
  SuiteRun run{suite.name, parse_seeds(request.seeds.value_or(suite.seeds)), {}};
  for (const regression::SuiteEntry& entry : suite.entries) {
    scenario::Changes changes = entry.changes;
    changes.overrides.insert(changes.overrides.end(), request.overrides.begin(), request.overrides.end());
    const scenario::ReadScenario read = scenario::read_scenario(entry.file, changes);
    run.scenarios.push_back({entry, read, {read.scenario.name, regression::config_of(read), {}}});
  }
  return run;
}

void run_jobs(const SuiteRequest& request, SuiteRun& run) {
  std::vector<ResultJob> jobs;
  for (const SuiteScenario& s : run.scenarios) {
    const double walk_s =
        slam::seconds(result::plan_end(s.read.scenario.walk));  // each second costs the same
    for (ResultJob& of_seed : jobs_of_seeds({s.read, s.read.scenario.name, {}, walk_s}, run.seeds))
      jobs.push_back(std::move(of_seed));
  }
  const OutFolder out(request, fs::path("results") / ("regress-" + run.name),
                      resumable(jobs, request.models, request.cached));
  Backend backend = request.backend;
  backend.seconds_each = request.cached ? 3 : 15;  // CPU time
  const auto ended = make_results(
      jobs, out,
      {.models = request.models,
       .title = fmt::format("suite {}, {} of {}", run.name, files::counted(run.scenarios.size(), "scenario"),
                            files::counted(run.seeds.size(), "seed")),
       .backend = backend,
       .cached = request.cached,
       .must_start = true});
  const std::vector<result::SeedScore> scores = read_scores(jobs, ended, out.path());
  for (std::size_t i = 0; i < scores.size(); ++i)
    run.scenarios[i / run.seeds.size()].results.seeds.push_back(scores[i]);
  out.finished();
}

/// Runs the suite, or reads its results.
void run_suite(const SuiteRequest& request, SuiteRun& run) {
  require_usable(request.backend, request.out.value_or(""));
  if (!request.results) {
    require_simulator();
    return run_jobs(request, run);
  }
  for (SuiteScenario& s : run.scenarios)
    for (const std::uint64_t seed : run.seeds) {
      scenario::Scenario scenario = s.read.scenario;
      scenario.seed = seed;
      const fs::path folder = *request.results / scenario.name / fmt::format("seed-{}", seed);
      if (!fs::exists(folder / "score.json"))
        throw UsageError("{}: there is no result of seed {}", folder.string(), seed);
      if (files::read_text(folder / "scenario.yaml") != scenario::to_yaml(scenario))
        throw UsageError("{}: was made with another configuration of {}; run it again", folder.string(),
                         scenario.name);
      s.results.seeds.push_back(regression::read_result(folder));
    }
}

/// The command that runs one seed of a scenario as the suite does.
std::string repro(const SuiteRequest& request, const SuiteScenario& scenario, std::uint64_t seed) {
  std::string command =
      fmt::format("tools/gaitslam run {} seed={}", files::shell_word(scenario.entry.file.string()), seed);
  for (const auto* changes : {&scenario.entry.changes.overrides, &request.overrides})
    for (const std::string& change : *changes) command += " " + files::shell_word(change);
  for (const std::string& section : scenario.entry.changes.without) command += " --without " + section;
  return command;
}

regression::Comparison compare_with(const std::vector<regression::ScenarioResults>& baseline,
                                    const SuiteRun& run, const SuiteRequest& request,
                                    const std::string& title) {
  std::vector<Judged> now;
  for (const SuiteScenario& s : run.scenarios)
    now.push_back({s.results, s.read.scenario, s.entry.gates,
                   [&](std::uint64_t seed) { return repro(request, s, seed); }, s.entry.file.string(),
                   s.entry.expects_missed});
  regression::Comparison comparison{title, verdicts_of(baseline, now, regression::default_gates())};
  for (regression::ScenarioVerdict& verdict : comparison.scenarios)
    if (verdict.file.empty()) verdict.file = request.suite.string();
  return comparison;
}

struct RegressRequest : SuiteRequest {
  VerdictFiles files;
  bool github = false;
};

/// Throws UsageError unless the baseline has the same configurations and all seeds of the run.
void require_comparable(const regression::Baseline& baseline, const SuiteRun& run, const std::string& file) {
  for (const SuiteScenario& scenario : run.scenarios) {
    const std::string& name = scenario.read.scenario.name;
    const regression::ScenarioResults* before = baseline.find(name);
    if (!before) continue;
    const auto differences = regression::config_differences(
        before->config,
        regression::config_of(scenario::read_scenario(scenario.entry.file, scenario.entry.changes)));
    if (!differences.empty())
      throw UsageError(
          "{}: {} has another configuration than the baseline {}: {}; run 'gaitslam baseline "
          "update' to store it",
          scenario.entry.file.string(), name, file, fmt::join(differences, "; "));
    for (const std::uint64_t seed : run.seeds)
      if (!before->find(seed))
        throw UsageError("{}: has no seed {} of {}; run 'gaitslam baseline update --seeds' to add seeds",
                         file, seed, name);
  }
}

int regress(RegressRequest& request) {
  require_replaceable(request.files);
  const std::string file = baseline_file(request).string();
  SuiteRun run = plan_suite(request);
  const regression::Baseline baseline = regression::read_baseline(file);
  require_comparable(baseline, run, file);
  run_suite(request, run);
  const std::string title = fmt::format("gaitslam regress: suite {} against {} (revision {})", run.name, file,
                                        baseline.history.empty() ? "?" : baseline.history.back().revision);
  const regression::Comparison comparison = compare_with(baseline.scenarios, run, request, title);
  report_verdicts(comparison, request.files);
  if (request.github) {
    text_out() << regression::github_annotations(comparison);
    if (const char* const summary = std::getenv("GITHUB_STEP_SUMMARY"))
      if (!(std::ofstream(summary, std::ios::app) << regression::markdown(comparison) << std::flush))
        throw files::FileError(summary, "cannot be written");
  }
  return regression::exit_code(comparison.scenarios);
}

struct BaselineRequest : SuiteRequest {
  std::string reason;
  bool dry_run = false;
};

/// Compares with the old baseline, whatever its configurations. Prints the verdicts, and changes of the
/// number of seeds, which these do not show. Returns the exit code by the limits only, because an update is
/// meant to change metrics.
int show(const regression::Baseline& before, const SuiteRun& run, const BaselineRequest& request,
         const std::string& file) {
  regression::Comparison comparison =
      compare_with(before.scenarios, run, request, "gaitslam baseline update: " + file + " before and after");
  std::cout << regression::verdict_table(comparison, colours());
  for (const SuiteScenario& s : run.scenarios) {
    const regression::ScenarioResults* old = before.find(s.results.name);
    if (old && old->seeds.size() != run.seeds.size())
      std::cout << fmt::format("{}: {} seeds -> {}\n", s.results.name, old->seeds.size(), run.seeds.size());
  }
  for (regression::ScenarioVerdict& verdict : comparison.scenarios) verdict.metrics.clear();
  return regression::exit_code(comparison.scenarios);
}

int update(BaselineRequest& request) {
  if (request.reason.find_first_not_of(" \t") == request.reason.npos)
    throw UsageError("--reason: is empty, expected the reason for the change");
  const std::string file = baseline_file(request).string();
  SuiteRun run = plan_suite(request);
  regression::Baseline baseline;
  if (fs::exists(file)) baseline = regression::read_baseline(file);
  run_suite(request, run);
  if (const int code = show(baseline, run, request, file); code != 0) {
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

void add_regress(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(
      app, exit_code, "regress", "Run a suite and compare it with its baseline", kRegressExamples, regress);
  command.add_option("suite", request.suite, "the suite's YAML file")->required();
  add_overrides(command, request.overrides, "in all scenarios");
  add_suite_options(command, request);
  add_verdict_files(command, request.files);
  command.add_flag("--github", request.github, "annotate the log and the summary of a GitHub Actions job");
}

void add_baseline(CLI::App& app, int& exit_code) {
  CLI::App& baseline = *app.add_subcommand("baseline", "Manage the results that a suite is compared with");
  baseline.require_subcommand(1);
  baseline.footer(kBaselineExamples);
  auto [command, request] =
      add_command(baseline, exit_code, "update", "Run a suite and store its scores as the baseline",
                  kBaselineExamples, update);
  command.add_option("suite", request.suite, "the suite's YAML file")->capture_default_str();
  command.add_option("--reason", request.reason, "why, stored in the baseline")->required();
  add_suite_options(command, request);
  command.add_flag("--dry-run", request.dry_run, "show what would change and write nothing");
}

}  // namespace cli
