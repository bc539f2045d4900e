#include "tools/cli/suite_run.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>

#include "sim/bench/result_set.h"
#include "sim/stream/file_error.h"
#include "tools/cli/batch.h"
#include "tools/cli/commands.h"
#include "tools/cli/live.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/seeds.h"

namespace cli {
namespace {

namespace bench = sim::bench;
namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A result that is judged in place of a run was made with the very scenario that would be run.
void require_made_with(const fs::path& folder, bench::Scenario scenario, std::uint64_t seed) {
  if (!fs::exists(folder / "score.json"))
    throw UsageError(fmt::format("{}: there is no result of seed {}", folder.string(), seed));
  scenario.seed = seed;
  if (text_of(folder / "scenario.yaml") != bench::to_yaml(scenario))
    throw UsageError(fmt::format("{}: was made with another configuration of {}; run it again",
                                 folder.string(), scenario.name));
}

bench::ScenarioResults read_results(const fs::path& root, const SuiteScenario& scenario,
                                    const std::vector<std::uint64_t>& seeds) {
  bench::ScenarioResults results{scenario.read.scenario.name, bench::config_of(scenario.read), {}};
  for (const std::uint64_t seed : seeds) {
    const fs::path folder = root / fmt::format("seed-{}", seed);
    require_made_with(folder, scenario.read.scenario, seed);
    results.seeds.push_back(bench::read_result(folder));
  }
  return results;
}

bench::ScenarioResults run_scenario(const SuiteRequest& request, const SuiteScenario& scenario,
                                    const fs::path& root, const std::vector<std::uint64_t>& seeds) {
  Batch batch{seeds, root, request.models, {}, scenario.read.origin, request.cached, request.backend};
  batch.backend.spool = root / ".slurm";
  batch.backend.seconds_each = request.cached || request.recordings ? 3 : 15;  // of computing
  if (request.recordings) batch.recordings = *request.recordings / scenario.read.scenario.name;
  bench::ScenarioResults results{scenario.read.scenario.name, bench::config_of(scenario.read), {}};
  for (const SeedOutcome& outcome : run_batch(scenario.read.scenario, batch)) {
    if (outcome.exit_code == 2) throw UsageError(fmt::format("seed {}: {}", outcome.seed, outcome.complaint));
    if (outcome.exit_code > 1)
      std::cerr << fmt::format("{} seed {}: {}", results.name, outcome.seed, outcome.complaint);
    const fs::path folder = root / fmt::format("seed-{}", outcome.seed);
    results.seeds.push_back(fs::exists(folder / "score.json")
                                ? bench::read_result(folder)
                                : bench::read_seed_score(root, outcome.seed, outcome.exit_code));
  }
  return results;
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

/// The command that runs one seed of a scenario as the suite does.
std::string repro(const SuiteRequest& request, const SuiteScenario& scenario, std::uint64_t seed) {
  std::string command = "tools/gaitslam ";
  const std::string file = shell_word(scenario.entry.file.string());
  if (request.recordings) {
    const fs::path recorded =
        *request.recordings / scenario.read.scenario.name / fmt::format("seed-{}", seed);
    command += fmt::format("replay {} --scenario {}", shell_word(recorded.string()), file);
  } else {
    command += "run " + file;
  }
  command += fmt::format(" seed={}", seed);
  for (const auto* changes : {&scenario.entry.changes.overrides, &request.overrides})
    for (const std::string& change : *changes) command += " " + shell_word(change);
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
  command.add_option("--baseline", request.baseline, "the baseline's file; else ../baselines/<suite>.json");
  command.add_option("--seeds", request.seeds, "instead of the suite's: 1..10 or 1,2,7");
  add_backend_options(command, request.backend);
  command.add_option("--recordings", request.recordings,
                     "replay the recordings in DIR/<scenario>/seed-<n> instead of walking");
  command.add_option("--results", request.results,
                     "judge the results in DIR/<scenario>/seed-<n>, run nothing");
  command.add_flag("--cached", request.cached,
                   "replay the recordings that the cache has, put there what it has not");
  command.add_option("--out", request.out, "folder for the results");
  command.add_option("--models", request.models, "folder of the robot's and room's models");
  command.add_flag("--force", request.force, "write into a folder that exists");
}

fs::path baseline_file(const SuiteRequest& request) {
  if (request.baseline) return *request.baseline;
  return (request.suite.parent_path() / ".." / "baselines" / request.suite.stem())
             .lexically_normal()
             .string() +
         ".json";
}

SuiteRun plan_suite(const SuiteRequest& request) {
  const bench::Suite suite = bench::read_suite(request.suite);
  for (const std::string& change : request.overrides)
    if (change.starts_with("seed=") || change.starts_with("name="))
      throw UsageError(change + ": a suite has names and seeds of its own, expected --seeds");
  SuiteRun run{suite.name, parse_seeds(request.seeds.value_or(suite.seeds)), {}};
  for (const bench::SuiteEntry& entry : suite.entries) {
    bench::Changes changes = entry.changes;
    changes.overrides.insert(changes.overrides.end(), request.overrides.begin(), request.overrides.end());
    run.scenarios.push_back({entry,
                             bench::read_scenario(entry.file, changes),
                             bench::config_of(bench::read_scenario(entry.file, entry.changes)),
                             {}});
  }
  return run;
}

void run_suite(const SuiteRequest& request, SuiteRun& run) {
  if (request.results) {
    for (SuiteScenario& s : run.scenarios)
      s.results = read_results(*request.results / s.read.scenario.name, s, run.seeds);
    return;
  }
  if (request.cached && request.recordings)
    throw UsageError("--cached and --recordings are both given, expected one of them");
  request.recordings ? require_recordings(request, run) : require_simulator();
  const fs::path root = request.out ? fs::path(*request.out) : fs::path("results") / ("regress-" + run.name);
  check_out_folder(root, request.out.has_value(), request.force);
  const NewFolders made_for_this(root);
  for (SuiteScenario& s : run.scenarios)
    s.results = run_scenario(request, s, root / s.read.scenario.name, run.seeds);
}

bench::Comparison compare_with(const std::vector<bench::ScenarioResults>& baseline, const SuiteRun& run,
                               const SuiteRequest& request, const std::string& title) {
  bench::Comparison comparison{title, {}, {}, {}};
  for (const SuiteScenario& s : run.scenarios) {
    const auto before = std::find_if(baseline.begin(), baseline.end(),
                                     [&](const auto& b) { return b.name == s.read.scenario.name; });
    comparison.scenarios.push_back(
        before == baseline.end() ? bench::without_counterpart(s.results, s.entry.gates, bench::Verdict::added)
                                 : bench::compare(*before, s.results, s.entry.gates));
    comparison.scenarios.back().limits = bench::judge_limits(s.read.scenario, s.results.seeds);
  }
  for (const bench::ScenarioResults& before : baseline)
    if (!find(run, before.name))
      comparison.scenarios.push_back(
          bench::without_counterpart(before, bench::default_gates(), bench::Verdict::missing));
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

std::string shell_word(const std::string& text) {
  static constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=./,:@%";
  if (!text.empty() && text.find_first_not_of(kPlain) == text.npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

bool colours() { return isatty(STDOUT_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr; }

}  // namespace cli
