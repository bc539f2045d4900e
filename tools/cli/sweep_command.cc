#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "sim/files/atomic_file.h"
#include "sim/files/hash.h"
#include "sim/files/text.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/yaml.h"
#include "sim/tune/sweep_plan.h"
#include "sim/tune/sweep_scores.h"
#include "sim/tune/value_list.h"
#include "tools/cli/commands.h"
#include "tools/cli/finished.h"
#include "tools/cli/jobs/slurm.h"
#include "tools/cli/jobs/trial_parts.h"
#include "tools/cli/live.h"
#include "tools/cli/model_files.h"
#include "tools/cli/options.h"
#include "tools/cli/out_folder.h"
#include "tools/cli/recordings.h"
#include "tools/cli/version.h"

namespace cli {
namespace {

namespace scenario = sim::scenario;
namespace tune = sim::tune;

constexpr const char* kSweepExamples = R"help(
Examples:
  gaitslam sweep scenarios/tangent_circle.yaml slam.vision.sigma_px=1,1.5,2 --seeds 1..5 --jobs 2
  gaitslam sweep scenarios/hall.yaml 'slam.gyro.sigma_rad_s=logspace(0.003, 0.03, 5)' 'world.seed=range(1, 3, 1)'
  gaitslam sweep scenarios/hall.yaml 'zip(slam.vision.sigma_px=1,2, slam.vision.gate_sigma_px=2,4)'
  gaitslam sweep scenarios/hall.yaml 'slam.vision.sigma_px=loguniform(0.5, 5)' --samples 32
  gaitslam sweep sweep.yaml --jobs 2 --out DIR        # a file, as below
A file:
  scenarios: [tangent_circle.yaml, hall.yaml]         # or scenario: FILE
  seeds: 1..5
  grid:
    slam.vision.sigma_px: [1, 1.5, 2]
    slam.gyro.sigma_rad_s: logspace(0.003, 0.03, 5)   # also range(0, 1, 0.25), linspace(0, 1, 5)
  zip: {slam.height.sigma_m: [0.01, 0.02], slam.plan_position.sigma_m: [0.02, 0.04]}
  sample: {method: sobol, points: 32, keys: {slam.motion.sigma_acceleration_m_s2: "loguniform(0.1, 10)"}}
Every combination is tried on every scenario and seed. The filter runs on recordings from the cache; those that are
missing are simulated first. The results are scores.csv and scores.jsonl, the same bytes for any number of jobs, and
scenarios/, from which any trial can be run; gaitslam report draws them. A
sweep that is killed loses no finished trial, and the same command continues it.
Methods: values and ranges make a grid; sobol samples cover several keys evenly; random samples are independent. To
search for the best setting use gaitslam tune.
Exit codes: 0 all were tried; 2 wrong usage or configuration; 3 some crashed or could not be started.)help";

struct SweepRequest : OutRequest {
  std::string file;
  std::vector<std::string> arguments;
  scenario::Changes changes;
  std::optional<std::string> seeds;
  tune::Sampling sampling;
  fs::path models = standard_models();
  Backend backend;
  bool dry_run = false;
};

std::vector<std::uint64_t> seeds_of(const SweepRequest& request, const tune::SweepSpec& spec) {
  if (request.seeds) return parse_seeds(*request.seeds);
  if (!spec.seeds.empty()) return spec.seeds;
  return {scenario::read_scenario(spec.scenarios[0]).scenario.seed};
}

/// A plan, and for each of its trials the key and the recording that it replays.
struct Sweep {
  tune::SweepPlan plan;
  std::vector<std::string> keys, recordings;
  std::map<std::string, scenario::ReadScenario> scenario_of;  ///< by recording, the first that replays it
  std::set<std::string> missing;                              ///< recordings that are not in the cache
};

Sweep prepare(const SweepRequest& request, const Recordings& recordings) {
  const tune::SweepSpec spec = tune::read_sweep(request.file, request.arguments, request.sampling);
  Sweep sweep{tune::plan_sweep(spec, seeds_of(request, spec), request.changes), {}, {}, {}, {}};
  const std::string program = program_identity();
  for (std::size_t i = 0; i < sweep.plan.trials(); ++i) {
    const scenario::ReadScenario read = sweep.plan.scenario(i);
    const scenario::Scenario& scenario = read.scenario;
    sweep.recordings.push_back(recordings.key(scenario));
    sweep.keys.push_back(tune::trial_key({program, sweep.recordings[i], inputs_of(scenario)}));
    sweep.scenario_of.emplace(sweep.recordings[i], read);
  }
  for (const auto& [key, read] : sweep.scenario_of)
    if (!recordings.find(read.scenario)) sweep.missing.insert(key);
  return sweep;
}

/// In a walk that is steered by its estimate filter and errors shape the recording, too.
bool shapes_any_recording(const Sweep& sweep, const std::string& key) {
  const auto& all = sweep.scenario_of;
  return std::any_of(all.begin(), all.end(), [&](const auto& recorded) {
    return scenario::shapes_recording(recorded.second.scenario, key);
  });
}

std::vector<std::string> keys_that(const Sweep& sweep, bool shape_recordings) {
  std::vector<std::string> keys;
  for (const std::string& key : sweep.plan.keys)
    if (shapes_any_recording(sweep, key) == shape_recordings) keys.push_back(key);
  return keys;
}

std::string of_keys(const char* what, const std::vector<std::string>& keys) {
  return keys.empty() ? "" : fmt::format(" ({} {})", what, fmt::join(keys, ", "));
}

void announce(const Sweep& sweep) {
  const auto n = sim::files::counted;
  std::cout << fmt::format("{} = {} x {}: replays{} of {}{}\n", n(sweep.plan.trials(), "trial"),
                           n(sweep.plan.configurations.size(), "configuration"),
                           n(sweep.plan.seeds.size(), "seed"), of_keys("with other", keys_that(sweep, false)),
                           n(sweep.scenario_of.size(), "recording"),
                           of_keys("one for each value of", keys_that(sweep, true)));
  std::cout << fmt::format("{} in the cache, {} to be simulated\n",
                           n(sweep.scenario_of.size() - sweep.missing.size(), "recording"),
                           sweep.missing.size());
  std::cout.flush();
}

void list_configurations(const tune::SweepPlan& plan) {
  for (const tune::Configuration& configuration : plan.configurations) {
    std::cout << configuration.read.scenario.name;
    for (std::size_t k = 0; k < plan.keys.size(); ++k)
      std::cout << ' ' << plan.keys[k] << '=' << configuration.values[k];
    std::cout << '\n';
  }
}

/// The first line of the log, which identifies the sweep.
std::string purpose(const Sweep& sweep) {
  sim::files::Hash hash;
  for (const std::string& key : sweep.keys) hash.add(key);
  return fmt::format(R"({{"log":"trials","of":"{}","trials":{},"hash":"{}"}})", sweep.plan.name,
                     sweep.keys.size(), hash.hex());
}

/// Throws UsageError when the folder has the log of another sweep.
void require_own_log(const fs::path& log, const std::string& purpose) {
  if (!fs::exists(log)) return;
  const std::string text = sim::files::read_text(log);
  const std::size_t end = text.find('\n');  // none: a process was killed while it wrote the line
  if (end != text.npos && std::string_view(text).substr(0, end) != purpose)
    throw UsageError(fmt::format(
        "{}: is of another sweep, other scenarios, another program or other files of the estimator; --force "
        "starts again, --out names another folder",
        log.string()));
}

/// Removes the trials of an earlier sweep, once, and leaves its scores until new ones replace them.
void remove_earlier_trials(const OutFolder& folder) {
  constexpr const char* kRemoved = "earlier trials removed";
  if (folder.has_made(kRemoved)) return;
  fs::remove(folder.path() / "trials.jsonl");
  remove_parts(folder.path() / "parts");
  remove_arrays(folder.path() / "slurm");
  folder.note_made(kRemoved);
}

void make_recordings(const Sweep& sweep, const Recordings& recordings, const Backend& backend) {
  std::vector<scenario::ReadScenario> scenarios;
  for (const std::string& key : sweep.missing) scenarios.push_back(sweep.scenario_of.at(key));
  if (scenarios.empty()) return;
  require_simulator();
  recordings.make(scenarios, backend);  // the trials of a recording that could not be made report it
}

/// The tasks without a record in the log. Those that share a recording follow each other.
std::vector<tune::Task> tasks_left(const Sweep& sweep, const tune::TrialLog& log) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < sweep.keys.size(); ++i)
    if (!log.find(sweep.keys[i])) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sweep.recordings[a] < sweep.recordings[b]; });
  std::vector<tune::Task> tasks;
  for (const std::size_t i : order)
    tasks.push_back({sweep.keys[i], scenario::to_yaml(sweep.plan.scenario(i).scenario)});
  return tasks;
}

/// The scenarios as they were swept, so that any trial can be run from the folder.
void write_scenarios(const Sweep& sweep, const fs::path& out) {
  std::set<std::string> written;
  fs::create_directories(out / "scenarios");
  for (const tune::Configuration& configuration : sweep.plan.configurations) {
    const scenario::Scenario& scenario = configuration.read.scenario;
    if (written.insert(scenario.name).second)
      sim::files::write_atomically(out / "scenarios" / (scenario.name + ".yaml"),
                                   scenario::to_yaml(scenario));
  }
}

/// Writes and prints the scores; returns the exit code.
int finish(const Sweep& sweep, const tune::TrialLog& log, const fs::path& out) {
  const tune::RecordOf record = [&](std::size_t i) { return log.find(sweep.keys[i]); };
  sim::files::write_atomically(out / "scores.csv", tune::scores_csv(sweep.plan, record));
  sim::files::write_atomically(out / "scores.jsonl", tune::scores_jsonl(sweep.plan, record));
  std::cout << tune::sweep_table(sweep.plan, record);
  std::map<std::string, int> causes;
  for (std::size_t i = 0; i < sweep.keys.size(); ++i) {
    const tune::TrialRecord* const one = record(i);
    if (!one)
      ++causes["not tried"];
    else if (one->ending == "crashed" || one->ending == "not begun" || one->ending == "failed")
      ++causes[one->ending + ": " + one->cause];
  }
  for (const auto& [cause, n] : causes)
    std::cerr << fmt::format("gaitslam: {} of {} trials {}\n", n, sweep.keys.size(), cause);
  std::cout << fmt::format("scores in {}\n", (out / "scores.csv").string());
  return causes.empty() ? 0 : 3;
}

int sweep(const SweepRequest& request) {
  require_usable(request.backend, request.out.value_or(""));
  const Recordings recordings(request.models);
  const Sweep sweep = prepare(request, recordings);
  announce(sweep);
  if (request.dry_run) {
    list_configurations(sweep.plan);
    return 0;
  }
  const fs::path standard = fs::path("results") / ("sweep-" + sweep.plan.name);
  const fs::path old_log = (request.out ? fs::path(*request.out) : standard) / "trials.jsonl";
  if (!request.force) require_own_log(old_log, purpose(sweep));
  const OutFolder folder(
      request, standard,
      {.names = {"trials.jsonl", "scores.csv", "scores.jsonl", "scenarios/", "parts/", "slurm/"},
       .continues = fs::exists(old_log),
       .identity = purpose(sweep) + (request.force ? " --force" : "")});
  const fs::path& out = folder.path();
  if (request.force) remove_earlier_trials(folder);
  fs::create_directories(out);
  write_scenarios(sweep, out);
  tune::TrialLog log(out / "trials.jsonl", purpose(sweep));
  Backend backend = request.backend;
  backend.spool = out / "slurm";
  const std::vector<tune::Task> left = tasks_left(sweep, log);
  if (log.size() > 0)
    std::cout << fmt::format("{} {} finished before\n", sim::files::counted(log.size(), "trial"),
                             log.size() == 1 ? "was" : "were");
  if (!left.empty()) {
    make_recordings(sweep, recordings, backend);
    run_parts(left, log, {out / "parts", purpose(sweep), request.models, "sweep " + sweep.plan.name},
              backend);
  }
  remove_arrays(backend.spool);
  log.sort();
  const int exit_code = finish(sweep, log, out);
  folder.finished();
  return exit_code;
}

}  // namespace

void add_sweep(CLI::App& app, int& exit_code) {
  auto request = std::make_shared<SweepRequest>();
  CLI::App* command = app.add_subcommand("sweep", "Try many values of a scenario's keys and score them");
  command->add_option("file", request->file, "the YAML file of a sweep or of a scenario")->required();
  command->add_option("values", request->arguments, "values to try (gaitslam config --keys)")
      ->option_text("key=a,b,c ... zip(key=a,b, key=c,d) ...");
  command->add_option("--seeds", request->seeds, "seeds, as in 1..5 or 1,2,7, instead of those of the file");
  command
      ->add_option("--samples", request->sampling.points,
                   "number of samples of uniform(a, b) and loguniform(a, b) on the command line")
      ->check(CLI::Range(std::size_t{1}, tune::kMostTrials))
      ->capture_default_str();
  command->add_option("--sampling", request->sampling.method, "method of these samples")
      ->check(CLI::IsMember({"sobol", "random"}))
      ->capture_default_str();
  add_backend_options(*command, request->backend);
  add_without(*command, request->changes);
  add_with(*command, request->changes);
  add_out(*command, *request);
  add_models(*command, request->models);
  command->add_flag("--dry-run", request->dry_run,
                    "print what would be tried and simulated, and run nothing");
  command->footer(kSweepExamples);
  command->callback([request, &exit_code] { exit_code = sweep(*request); });
}

}  // namespace cli
