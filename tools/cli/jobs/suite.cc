#include "tools/cli/jobs/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <set>
#include <string_view>

#include "sim/files/atomic_file.h"
#include "sim/files/text.h"
#include "sim/regression/results.h"
#include "sim/result/result.h"
#include "sim/scenario/recording_key.h"
#include "tools/cli/shared/live.h"

namespace cli {
namespace {

/// A format of verdicts, and the first bytes of its files.
struct VerdictFormat {
  const char* option;
  std::string_view start;
  std::string (*text)(const regression::Comparison&);
};
constexpr std::array kFormats{
    VerdictFormat{"--junit", "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"gaitslam ",
                  regression::junit},
    VerdictFormat{"--markdown", "### gaitslam ", regression::markdown},
    VerdictFormat{"--json", "{\n  \"title\": \"gaitslam ", regression::verdicts_json}};

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

/// A second of simulated walk costs the same in each scenario.
std::vector<ResultJob> jobs_of(const SuiteRun& run) {
  std::vector<ResultJob> jobs;
  for (const SuiteScenario& s : run.scenarios) {
    const ResultJob job{
        s.read, s.read.scenario.name, {}, slam::seconds(result::plan_end(s.read.scenario.walk))};
    for (ResultJob& of_seed : jobs_of_seeds(job, run.seeds)) jobs.push_back(std::move(of_seed));
  }
  return jobs;
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
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (ended[i].exit_code == 2)  // it could not start
      throw UsageError(fmt::format("seed {}: {}", jobs[i].seed(), ended[i].complaint));
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
  command.add_option("--baseline", request.baseline, "instead of ../baselines/<suite>.json");
  add_seeds(command, request.seeds, "seeds instead of those of the suite");
  add_backend_options(command, request.backend);
  command.add_option("--results", request.results, "judge DIR/<scenario>/seed-<n>, run nothing");
  add_cached(command, request.cached);
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

std::vector<regression::ScenarioVerdict> verdicts_of(const std::vector<regression::ScenarioResults>& baseline,
                                                     const std::vector<Judged>& now,
                                                     const std::vector<regression::Gate>& gates_of_missing) {
  std::vector<regression::ScenarioVerdict> verdicts;
  std::set<std::string> judged;
  for (const Judged& one : now) {
    const auto before = std::find_if(baseline.begin(), baseline.end(),
                                     [&](const auto& b) { return b.name == one.results.name; });
    verdicts.push_back(regression::compare(before == baseline.end() ? regression::ScenarioResults() : *before,
                                           one.results, one.gates));
    verdicts.back().limits = regression::judge_limits(one.scenario, one.results.seeds, one.expects_missed);
    judged.insert(one.results.name);
  }
  for (const regression::ScenarioResults& before : baseline)
    if (!judged.contains(before.name))
      verdicts.push_back(regression::compare(before, {before.name, {}, {}}, gates_of_missing));
  return verdicts;
}

regression::Comparison compare_with(const std::vector<regression::ScenarioResults>& baseline,
                                    const SuiteRun& run, const SuiteRequest& request,
                                    const std::string& title) {
  regression::Comparison comparison{title, {}, {}, {}};
  std::vector<Judged> now;
  for (const SuiteScenario& s : run.scenarios)
    now.push_back({s.results, s.read.scenario, s.entry.gates, s.entry.expects_missed});
  comparison.scenarios = verdicts_of(baseline, now, regression::default_gates());
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

void add_verdict_files(CLI::App& command, VerdictFiles& files) {
  command.add_option("--junit", files[0], "write JUnit XML to a file");
  command.add_option("--markdown", files[1], "write Markdown tables to a file");
  add_quiet(command);
  const auto take_json = [&files](const std::string& file) {
    if (file.empty())  // CLI11 passes this for an option without a value
      choose_output(Output::json);
    else
      files[2] = file;
  };
  command
      .add_option_function<std::string>(
          "--json", take_json, "print only JSON (schemas/verdicts.schema.json), or write it to a file")
      ->expected(0, 1)
      ->option_text("[FILE]")
      ->excludes("--quiet");
}

void require_replaceable(const VerdictFiles& files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!files[i]) continue;
    require_folder_of(*files[i], kFormats[i].option);
    if (!fs::exists(fs::symlink_status(*files[i]))) continue;
    sim::files::require_regular(*files[i]);
    sim::files::InputFile in(*files[i], sim::files::kMostOfText);
    const std::string_view found = in.next();
    if (!found.empty() && !found.starts_with(kFormats[i].start))
      throw UsageError(fmt::format(
          "{}: exists and was not written by gaitslam; name another file, or remove it", files[i]->string()));
  }
}

void report_verdicts(const regression::Comparison& comparison, const VerdictFiles& files) {
  text_out() << regression::verdict_table(comparison, colours());
  if (output() == Output::json) std::cout << regression::verdicts_json(comparison);
  for (std::size_t i = 0; i < files.size(); ++i)
    if (files[i]) sim::files::write_atomically(*files[i], kFormats[i].text(comparison));
}

}  // namespace cli
