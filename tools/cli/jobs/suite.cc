#include "tools/cli/jobs/suite.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/files/text.h"
#include "sim/regression/results.h"
#include "sim/result/score_input.h"
#include "sim/scenario/recording_key.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

namespace regression = sim::regression;
namespace result = sim::result;
namespace scenario = sim::scenario;

/// Throws UsageError unless the result was made with the scenario that would be run.
void require_made_with(const fs::path& folder, scenario::Scenario scenario, std::uint64_t seed) {
  if (!fs::exists(folder / "score.json"))
    throw UsageError(fmt::format("{}: there is no result of seed {}", folder.string(), seed));
  scenario.seed = seed;
  if (sim::files::read_text(folder / "scenario.yaml") != scenario::to_yaml(scenario))
    throw UsageError(fmt::format("{}: was made with another configuration of {}; run it again",
                                 folder.string(), scenario.name));
}

regression::ScenarioResults read_results(const fs::path& root, const SuiteScenario& scenario,
                                         const std::vector<std::uint64_t>& seeds) {
  regression::ScenarioResults results{scenario.read.scenario.name, regression::config_of(scenario.read), {}};
  for (const std::uint64_t seed : seeds) {
    const fs::path folder = root / fmt::format("seed-{}", seed);
    require_made_with(folder, scenario.read.scenario, seed);
    results.seeds.push_back(regression::read_result(folder));
  }
  return results;
}

/// The planned time of a walk.
double planned_s(const walking::WalkOptions& walk) {
  const auto steps = result::planned_times(walk).footsteps;
  return steps.empty() ? 1 : std::max(1.0, slam::seconds(steps.back()));
}

/// A second of simulated walk costs the same in each scenario.
std::vector<ResultJob> jobs_of(const SuiteRun& run) {
  std::vector<ResultJob> jobs;
  for (const SuiteScenario& s : run.scenarios) {
    const ResultJob job{s.read, s.read.scenario.name, {}, planned_s(s.read.scenario.walk)};
    for (ResultJob& of_seed : jobs_of_seeds(job, run.seeds)) jobs.push_back(std::move(of_seed));
  }
  return jobs;
}

/// Throws UsageError if a job could not start.
void require_started(const std::vector<ResultJob>& jobs, const std::vector<Ended>& ended) {
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (ended[i].exit_code == 2)
      throw UsageError(fmt::format("seed {}: {}", jobs[i].seed(), ended[i].complaint));
}

void run_jobs(const SuiteRequest& request, SuiteRun& run) {
  const std::vector<ResultJob> jobs = jobs_of(run);
  const OutFolder out(request, fs::path("results") / ("regress-" + run.name),
                      {.results = results_of(jobs),
                       .identity = identity_of(
                           jobs, {scenario::models_hash(request.models), request.cached ? "cached" : ""})});
  Backend backend = request.backend;
  backend.seconds_each = request.cached ? 3 : 15;  // CPU time
  const auto ended = make_results(jobs, out,
                                  {.models = request.models,
                                   .title = fmt::format("suite {}, {} of {}", run.name,
                                                        sim::files::counted(run.scenarios.size(), "scenario"),
                                                        sim::files::counted(run.seeds.size(), "seed")),
                                   .backend = backend,
                                   .cached = request.cached});
  require_started(jobs, ended);
  print_complaints(jobs, ended);
  const std::vector<result::SeedScore> scores = read_scores(jobs, ended, out.path());
  for (std::size_t i = 0; i < run.scenarios.size(); ++i) {
    SuiteScenario& s = run.scenarios[i];
    const auto first = scores.begin() + static_cast<std::ptrdiff_t>(i * run.seeds.size());
    s.results = {s.read.scenario.name,
                 regression::config_of(s.read),
                 {first, first + static_cast<std::ptrdiff_t>(run.seeds.size())}};
  }
  out.finished();
}

/// The command that runs one seed of a scenario as the suite does.
std::string repro(const SuiteRequest& request, const SuiteScenario& scenario, std::uint64_t seed) {
  std::string command = fmt::format("tools/gaitslam run {} seed={}",
                                    sim::files::shell_word(scenario.entry.file.string()), seed);
  for (const auto* changes : {&scenario.entry.changes.overrides, &request.overrides})
    for (const std::string& change : *changes) command += " " + sim::files::shell_word(change);
  for (const std::string& section : scenario.entry.changes.without) command += " --without " + section;
  return command;
}

const SuiteScenario* find(const SuiteRun& run, const std::string& name) {
  for (const SuiteScenario& scenario : run.scenarios)
    if (scenario.read.scenario.name == name) return &scenario;
  return nullptr;
}

}  // namespace

void add_suite_options(CLI::App& command, SuiteRequest& request) {
  command.add_option("--baseline", request.baseline,
                     "the file of the baseline, instead of ../baselines/<suite>.json");
  command.add_option("--seeds", request.seeds, "seeds, as in 1..10 or 1,2,7, instead of those of the suite");
  add_backend_options(command, request.backend);
  command.add_option("--results", request.results,
                     "judge the results in DIR/<scenario>/seed-<n> and run nothing");
  command.add_flag("--cached", request.cached, "replay recordings from the cache; record missing ones first");
  add_out(command, request);
  add_models(command, request.models);
}

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
    run.scenarios.push_back({entry,
                             scenario::read_scenario(entry.file, changes),
                             regression::config_of(scenario::read_scenario(entry.file, entry.changes)),
                             {}});
  }
  return run;
}

void run_suite(const SuiteRequest& request, SuiteRun& run) {
  require_usable(request.backend, request.out.value_or(""));
  if (request.results) {
    for (SuiteScenario& s : run.scenarios)
      s.results = read_results(*request.results / s.read.scenario.name, s, run.seeds);
    return;
  }
  require_simulator();
  run_jobs(request, run);
}

regression::Comparison compare_with(const std::vector<regression::ScenarioResults>& baseline,
                                    const SuiteRun& run, const SuiteRequest& request,
                                    const std::string& title) {
  regression::Comparison comparison{title, {}, {}, {}};
  for (const SuiteScenario& s : run.scenarios) {
    const auto before = std::find_if(baseline.begin(), baseline.end(),
                                     [&](const auto& b) { return b.name == s.read.scenario.name; });
    comparison.scenarios.push_back(
        before == baseline.end()
            ? regression::without_counterpart(s.results, s.entry.gates, regression::Verdict::added)
            : regression::compare(*before, s.results, s.entry.gates));
    comparison.scenarios.back().limits = regression::judge_limits(s.read.scenario, s.results.seeds);
  }
  for (const regression::ScenarioResults& before : baseline)
    if (!find(run, before.name))
      comparison.scenarios.push_back(
          regression::without_counterpart(before, regression::default_gates(), regression::Verdict::missing));
  comparison.file = [&run, &request](const std::string& name) {
    const SuiteScenario* scenario = find(run, name);
    return scenario ? scenario->entry.file.string() : request.suite.string();
  };
  comparison.repro = [&run, &request](const std::string& name, std::uint64_t seed) {
    const SuiteScenario* scenario = find(run, name);
    return scenario ? repro(request, *scenario, seed) : "";
  };
  return comparison;
}

}  // namespace cli
