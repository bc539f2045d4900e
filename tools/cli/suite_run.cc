#include "tools/cli/suite_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <numeric>

#include "sim/files/text.h"
#include "sim/regression/result_set.h"
#include "sim/result/score_input.h"
#include "sim/tune/recording_key.h"
#include "tools/cli/finished.h"
#include "tools/cli/jobs/batch.h"
#include "tools/cli/jobs/earlier.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/live.h"
#include "tools/cli/options.h"

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

regression::ScenarioResults run_scenario(const SuiteRequest& request, const SuiteScenario& scenario,
                                         const OutFolder& out, const std::vector<std::uint64_t>& seeds,
                                         const ShowPart& show) {
  const std::string& name = scenario.read.scenario.name;
  const fs::path root = out.path() / name;
  // On Slurm the job array knows what has ended.
  const auto left =
      request.backend.slurm() ? seeds : unfinished(out, name + "/", scenario.read.scenario, seeds);
  Batch batch{left, root, request.models, {}, scenario.read.origin, request.cached, request.backend};
  batch.progress = show;
  batch.on_made = [&](std::uint64_t seed) { out.note_made(fmt::format("{}/seed-{}", name, seed)); };
  batch.backend.spool = root / ".slurm";
  batch.backend.seconds_each = request.cached || request.recordings ? 3 : 15;  // CPU time
  if (request.recordings) batch.recordings = *request.recordings / scenario.read.scenario.name;
  regression::ScenarioResults results{scenario.read.scenario.name, regression::config_of(scenario.read), {}};
  std::map<std::uint64_t, int> exit_codes;
  for (const SeedOutcome& outcome : run_batch(scenario.read.scenario, batch)) {
    if (outcome.exit_code == 2) throw UsageError(fmt::format("seed {}: {}", outcome.seed, outcome.complaint));
    if (outcome.exit_code > 1)
      std::cerr << fmt::format("{} seed {}: {}", results.name, outcome.seed, outcome.complaint);
    exit_codes[outcome.seed] = outcome.exit_code;
  }
  set_aside(root, results_of_other_seeds(root, seeds));
  for (const std::uint64_t seed : seeds) {
    const fs::path folder = root / fmt::format("seed-{}", seed);
    results.seeds.push_back(fs::exists(folder / "score.json")
                                ? regression::read_result(folder)
                                : result::read_seed_score(root, seed, exit_codes[seed]));
  }
  return results;
}

/// One progress line for all scenarios: a second of simulated walk counts alike in each.
void run_scenarios(const SuiteRequest& request, SuiteRun& run, const OutFolder& out) {
  ProgressLine progress(fmt::format("suite {}, {} of {}", run.name,
                                    sim::files::counted(run.scenarios.size(), "scenario"),
                                    sim::files::counted(run.seeds.size(), "seed")));
  std::vector<double> walks_s;
  for (const SuiteScenario& s : run.scenarios) walks_s.push_back(planned_s(s.read.scenario.walk));
  const double total_s = std::accumulate(walks_s.begin(), walks_s.end(), 0.0);
  double before_s = 0;
  for (std::size_t i = 0; i < walks_s.size(); ++i) {
    SuiteScenario& s = run.scenarios[i];
    const std::string& name = s.read.scenario.name;
    const auto show = [&](double part) { progress.show((before_s + part * walks_s[i]) / total_s, name); };
    s.results = run_scenario(request, s, out, run.seeds, show);
    before_s += walks_s[i];
  }
}

void require_recordings(const SuiteRequest& request, const SuiteRun& run) {
  for (const SuiteScenario& scenario : run.scenarios)
    for (const std::uint64_t seed : run.seeds) {
      const fs::path folder =
          *request.recordings / scenario.read.scenario.name / fmt::format("seed-{}", seed);
      if (!fs::is_directory(folder / "recording"))
        throw UsageError(fmt::format("{}: there is no recording of seed {}", folder.string(), seed));
    }
}

std::vector<std::string> results_of(const SuiteRun& run) {
  std::vector<std::string> all;
  for (const SuiteScenario& s : run.scenarios)
    for (const std::uint64_t seed : run.seeds)
      all.push_back(fmt::format("{}/seed-{}", s.read.scenario.name, seed));
  return all;
}

std::string identity_of(const SuiteRun& run, const SuiteRequest& request) {
  std::vector<std::string> scenarios{request.recordings ? "" : sim::tune::models_hash(request.models)};
  for (const SuiteScenario& s : run.scenarios) scenarios.push_back(inputs_of(s.read.scenario));
  return identity_of_runs(scenarios, run.seeds,
                          fmt::format("{}\n{}", request.cached ? "cached" : "",
                                      request.recordings ? request.recordings->string() : ""));
}

/// The command that runs one seed of a scenario as the suite does.
std::string repro(const SuiteRequest& request, const SuiteScenario& scenario, std::uint64_t seed) {
  std::string command = "tools/gaitslam ";
  const std::string file = sim::files::shell_word(scenario.entry.file.string());
  if (request.recordings) {
    const fs::path recorded =
        *request.recordings / scenario.read.scenario.name / fmt::format("seed-{}", seed);
    command += fmt::format("replay {} --scenario {}", sim::files::shell_word(recorded.string()), file);
  } else {
    command += "run " + file;
  }
  command += fmt::format(" seed={}", seed);
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
  command.add_option("--recordings", request.recordings,
                     "replay the recordings in DIR/<scenario>/seed-<n> instead of simulating");
  command.add_option("--results", request.results,
                     "judge the results in DIR/<scenario>/seed-<n> and run nothing");
  command.add_flag("--cached", request.cached,
                   "replay recordings from the cache; record those that are missing there first");
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
  if (request.cached && request.recordings)
    throw UsageError("--cached and --recordings are both given, expected one of them");
  request.recordings ? require_recordings(request, run) : require_simulator();
  const OutFolder out(request, fs::path("results") / ("regress-" + run.name),
                      {.results = results_of(run), .identity = identity_of(run, request)});
  if (request.recordings)
    for (const SuiteScenario& s : run.scenarios)
      for (const std::uint64_t seed : run.seeds)
        require_outside(out.path() / s.read.scenario.name / fmt::format("seed-{}", seed),
                        *request.recordings / s.read.scenario.name / fmt::format("seed-{}", seed));
  run_scenarios(request, run, out);
  out.finished();
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
