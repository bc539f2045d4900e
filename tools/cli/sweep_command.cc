// The commands that try many settings: sweep tries given values, tune searches for the best ones.

#include <iostream>

#include "sim/pages/pages.h"
#include "sim/trials/sweep.h"
#include "sim/trials/tuning.h"
#include "tools/cli/commands.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/results.h"
#include "tools/cli/shared/options.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

struct TrialsRequest {
  fs::path jobs, records;
  BatchMember batch;
};

int run_listed(TrialsRequest& request) {
  join_batch(request.batch);
  const Recordings recordings(standard_models());
  std::string loaded;  // successive trials mostly use the same recording
  std::shared_ptr<const trials::Recording> recording;
  const auto recording_of = [&](const fs::path& named, const scenario::ReadScenario& read) {
    const std::string name = named.empty() ? recordings.key(read.scenario) : named.string();
    if (name == loaded) return recording;
    loaded.clear(), recording.reset();
    std::optional<recording::CachedRecording> cached;  // marks it as in use
    if (named.empty()) cached.emplace(recordings.get(read, [](double) {}));
    recording = std::make_shared<const trials::Recording>(trials::load(cached ? cached->folder : named));
    loaded = name;
    return recording;
  };
  ProgressLine progress("trials");
  std::vector<JobRecord> records;
  const std::vector<Job> jobs = jobs_in(request.jobs);
  for (const Job& job : jobs) {
    const trials::Task task{job.key, job.seed, job.scenario, job.recording};
    records.push_back(run_task(task, [&](const auto& read, const std::string& session) {
      const fs::path beside = job.recording / session;  // not if the recording is in the cache
      return recording_of(session.empty()                                ? job.recording
                          : !job.recording.empty() && fs::exists(beside) ? beside
                                                                         : fs::path(),
                          read);
    }));
    progress.show(double(records.size()) / double(jobs.size()));
  }
  files::write_atomically(request.records, result::to_lines(records));
  return 0;
}

/// Returns a function that runs trials with run_jobs, in several processes on this machine or on a cluster,
/// and logs their records. Tasks on the same recording should follow each other.
trials::RunTasks in_processes(const std::string& title, const Backend& backend) {
  return [=](const std::vector<trials::Task>& tasks, result::JobLog& log) {
    std::vector<Job> jobs;
    for (const trials::Task& task : tasks)
      if (!log.find(task.key))
        jobs.push_back({.key = task.key,
                        .seed = task.seed,
                        .words = {"trials"},
                        .batched = true,
                        .scenario = task.scenario,
                        .recording = task.recording});
    run_jobs(jobs, backend, fmt::format("{}, {} trials", title, jobs.size()),
             [&](const std::vector<JobRecord>& records) { log.add(records); });
  };
}

constexpr const char* kSweepExamples = R"help(Examples:
  gaitslam sweep scenarios/tangent_circle.yaml slam.vision.sigma_px=1,1.5,2 --seeds 1..5 --jobs 2
  gaitslam sweep scenarios/hall.yaml 'slam.gyro.sigma_rad_s={from: 0.003, to: 0.03, points: 5}' world.seed=1,2,3
  gaitslam sweep scenarios/hall.yaml 'slam.vision.sigma_px={from: 0.5, to: 5}' --samples 32
  gaitslam sweep sweep.yaml --jobs 2 --out DIR  # {scenarios: [...], seeds: 1..5, parameters: {KEY: VALUES}}
Every combination is tried on every scenario and seed. A range with points is a logarithmically spaced grid (linearly with
scale: linear); ranges without points are sampled jointly (Sobol). `also` gives further keys the same value.
The filter runs on recordings from the cache; missing ones are simulated first. The results are scores.csv and
scores.jsonl, and scenarios/, from which any trial can be run; gaitslam report plots them. Rerun the command to resume
after an interruption. To search for the best setting, use gaitslam tune.
Exit codes: 0 all trials ran; 2 wrong usage or configuration; 3 some crashed or could not be started.)help";

struct SweepRequest : OutRequest {
  std::string file;
  std::vector<std::string> arguments;
  scenario::Changes changes;
  std::optional<std::string> seeds;
  std::optional<int> samples;
  Backend backend;
  bool dry_run = false;
};

/// A sweep's plan, with the key and the recording of each trial.
struct Sweep {
  trials::SweepPlan plan;
  std::string purpose;  ///< the first line of the log, which identifies the sweep
  std::vector<std::string> keys, recordings;
  std::map<std::string, scenario::ReadScenario> scenario_of;  ///< for each recording, the first to replay it
  std::set<std::string> missing;                              ///< recordings that are not in the cache
};

Sweep prepare(const SweepRequest& request, const Recordings& recordings) {
  const trials::SweepSpec spec = trials::read_sweep(request.file, request.arguments, request.samples);
  const std::vector<std::uint64_t> seeds =
      request.seeds        ? parse_seeds(*request.seeds)
      : spec.seeds.empty() ? std::vector{scenario::read_scenario(spec.scenarios[0]).scenario.seed}
                           : spec.seeds;
  Sweep sweep{trials::plan_sweep(spec, seeds, request.changes), {}, {}, {}, {}, {}};
  const std::string program = program_identity();
  files::Hash hash;
  for (std::size_t i = 0; i < sweep.plan.trials(); ++i) {
    const scenario::ReadScenario read = sweep.plan.scenario(i);
    const scenario::Scenario& scenario = read.scenario;
    sweep.recordings.push_back(recordings.key(scenario));
    sweep.keys.push_back(result::job_key({program, sweep.recordings[i], inputs_of(scenario)}));
    hash.add(sweep.keys[i]);
    sweep.scenario_of.emplace(sweep.recordings[i], read);
  }
  sweep.purpose = fmt::format(R"({{"log":"trials","of":"{}","trials":{},"hash":"{}"}})", sweep.plan.name,
                              sweep.keys.size(), hash.hex());
  for (const auto& [key, read] : sweep.scenario_of)
    if (!recordings.find(read.scenario)) sweep.missing.insert(key);
  return sweep;
}

void announce(const Sweep& sweep) {
  const auto n = files::counted;
  const std::size_t recordings = sweep.scenario_of.size(), missing = sweep.missing.size();
  std::cout << fmt::format("{} = {} x {}, on {}: {} in the cache, {} to be simulated\n",
                           n(sweep.plan.trials(), "trial"),
                           n(sweep.plan.configurations.size(), "configuration"),
                           n(sweep.plan.seeds.size(), "seed"), n(recordings, "recording"),
                           recordings - missing, missing)
            << std::flush;
}

void list_configurations(const trials::SweepPlan& plan) {
  for (const trials::Configuration& configuration : plan.configurations) {
    std::cout << configuration.read.scenario.name;
    for (std::size_t k = 0; k < plan.keys.size(); ++k)
      std::cout << ' ' << plan.keys[k] << '=' << configuration.labels[k];
    std::cout << '\n';
  }
}

/// True if the log belongs to another sweep. An incomplete first line was left by a killed process.
bool is_of_another(const fs::path& log, const Sweep& sweep) {
  const std::string text = fs::exists(log) ? files::read_text(log) : "";
  const std::size_t end = text.find('\n');
  return end != text.npos && text.substr(0, end) != sweep.purpose;
}

/// Returns the tasks without a record in the log, ordered by recording.
std::vector<trials::Task> tasks_left(const Sweep& sweep, const result::JobLog& log) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < sweep.keys.size(); ++i)
    if (!log.find(sweep.keys[i])) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return sweep.recordings[i]; });
  std::vector<trials::Task> tasks;
  for (const std::size_t i : order)
    tasks.push_back({sweep.keys[i], sweep.plan.seeds[i % sweep.plan.seeds.size()],
                     scenario::to_yaml(sweep.plan.scenario(i).scenario)});
  return tasks;
}

/// Writes the scenarios of the sweep, so that any trial can be run from the folder.
void write_scenarios(const Sweep& sweep, const fs::path& folder) {
  std::set<std::string> written;
  fs::create_directories(folder);
  for (const trials::Configuration& configuration : sweep.plan.configurations)
    if (const auto& scenario = configuration.read.scenario; written.insert(scenario.name).second)
      files::write_atomically(folder / (scenario.name + ".yaml"), scenario::to_yaml(scenario));
}

/// Writes and prints the scores; returns the exit code.
int finish(const Sweep& sweep, const result::JobLog& log, const fs::path& out) {
  const trials::RecordOf record = [&](std::size_t i) { return log.find(sweep.keys[i]); };
  const auto [csv, jsonl] = trials::scores(sweep.plan, record);
  files::write_atomically(out / "scores.csv", csv);
  files::write_atomically(out / "scores.jsonl", jsonl);
  std::cout << trials::sweep_table(sweep.plan, record);
  std::map<std::string, int> causes;
  for (std::size_t i = 0; i < sweep.keys.size(); ++i) {
    const result::JobRecord* const one = record(i);
    if (!one)
      ++causes["not tried"];
    else if (one->ending == "crashed" || one->ending == "not started" || one->ending == "failed")
      ++causes[one->ending + ": " + one->cause];
  }
  for (const auto& [cause, n] : causes)
    std::cerr << fmt::format("gaitslam: {} of {} trials {}\n", n, sweep.keys.size(), cause);
  std::cout << fmt::format("scores in {}\n", (out / "scores.csv").string());
  return causes.empty() ? 0 : 3;
}

int sweep(SweepRequest& request) {
  const Recordings recordings(standard_models());
  const Sweep sweep = prepare(request, recordings);
  const fs::path standard = fs::path("results") / ("sweep-" + sweep.plan.name);
  const fs::path log_file = (request.out ? fs::path(*request.out) : standard) / "trials.jsonl";
  const bool is_other = is_of_another(log_file, sweep);
  if (is_other && !request.force && !request.dry_run)
    throw UsageError(
        "{}: belongs to another sweep, or was made with other scenarios, another program or other estimator "
        "files; --force starts over, --out selects another folder",
        log_file.string());
  announce(sweep);
  if (request.dry_run) {
    list_configurations(sweep.plan);
    return 0;
  }
  const OutFolder folder(request, standard, OutUse::adds_results);
  const fs::path& out = folder.path();
  if (is_other) {
    clear_spool(out / "slurm");
    fs::remove(log_file);  // the scores stay until new ones replace them
  }
  write_scenarios(sweep, out / "scenarios");
  auto log = std::make_optional<result::JobLog>(log_file, sweep.purpose);
  if (request.force && tasks_left(sweep, *log).empty()) {
    fs::remove(log_file);
    log.emplace(log_file, sweep.purpose);
  }
  Backend backend = request.backend;
  backend.spool = out / "slurm";
  const std::vector<trials::Task> left = tasks_left(sweep, *log);
  if (log->size() > 0) std::cout << fmt::format("{} finished before\n", files::counted(log->size(), "trial"));
  if (!left.empty()) {
    std::vector<scenario::ReadScenario> missing;
    for (const std::string& key : sweep.missing) missing.push_back(sweep.scenario_of.at(key));
    recordings.make(missing, backend);  // the trials of a failed recording report it
    in_processes("sweep " + sweep.plan.name, backend)(left, *log);
  }
  log->sort();
  return finish(sweep, *log, out);
}

constexpr const char* kTuneExamples = R"(Examples:
  gaitslam tune scenarios/tuning/circles.yaml --jobs 2
  gaitslam run scenarios/tangent_circle.yaml --with results/tune-circles/best.yaml
Results are written to results/tune-<spec>, or to DIR: trials.jsonl (each finished trial), history.csv, tune.json,
report.html and best.yaml. Rerun the command to resume after an interruption; the result is the same. Recordings missing
from the cache are made first. If a walk is steered by its estimate, each setting is simulated. To try a grid or samples,
use gaitslam sweep.
Exit codes: 0 tuned; 1 no best.yaml was written, because the 95 % interval of the mean change in loss does not show that
the result is better than the start on the hold-out recordings; 2 wrong usage or configuration.)";

struct TuneRequest : OutRequest {
  std::string spec;
  Backend backend;
};

/// Makes the spec's missing recordings and sets the folders of the recordings in the cache, which are marked
/// as in use while the returned objects live.
std::vector<recording::CachedRecording> cached_recordings(trials::Spec& spec, const fs::path& models,
                                                          const Backend& backend) {
  std::vector<trials::SpecRun*> runs;
  std::vector<scenario::ReadScenario> scenarios;
  for (auto* side : {&spec.training, &spec.holdout})
    for (trials::SpecRun& run : *side) {
      if (!run.folder.empty()) continue;
      runs.push_back(&run);
      scenarios.push_back(run.read);
      scenarios.back().scenario.seed = run.recorded_seed;
    }
  std::vector<recording::CachedRecording> all;
  if (runs.empty()) return all;
  const Recordings recordings(models);
  const std::vector<Recordings::Made> made = recordings.make(scenarios, backend);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    auto recording = recordings.find(scenarios[i].scenario);
    if (!recording)
      throw UsageError("{} seed {} could not be recorded: {}", scenarios[i].scenario.name,
                       runs[i]->recorded_seed, made[i].record.cause);
    runs[i]->folder = recording->folder;
    all.push_back(std::move(*recording));
  }
  return all;
}

int tune_by(TuneRequest& request) {
  trials::Spec spec = trials::read_spec(request.spec);
  const fs::path standard = fs::path("results") / ("tune-" + spec.name);
  const OutFolder folder(request, standard, OutUse::adds_results);
  const fs::path& out = folder.path();
  Backend backend = request.backend;
  backend.spool = out / "slurm";
  const auto in_use = cached_recordings(spec, standard_models(), backend);
  const auto steered = [](const trials::SpecRun& run) {
    return run.read.scenario.walk.steering.by == walking::SteeredBy::estimate;
  };
  const bool simulates =
      std::ranges::any_of(spec.training, steered) || std::ranges::any_of(spec.holdout, steered);
  const trials::RunTasks run_trials = in_processes("tune " + request.spec, backend);
  if (simulates) std::cout << "a walk is steered by its estimate: each setting is simulated\n" << std::flush;
  trials::TuningResult result;
  {
    ProgressLine progress("tune " + spec.name);
    result = trials::tune(spec, out, run_trials, program_identity(),
                          [&](double part, const std::string& at) { progress.show(part, at); });
  }
  files::write_atomically(out / "report.html", pages::tune_page(out));
  std::cout << result.text << "results in " << out.string() << '\n';
  if (!result.accepted)
    std::cerr << fmt::format("gaitslam: rejected: {}; best.yaml was not written\n", result.judgment);
  return result.accepted ? 0 : 1;
}

}  // namespace

void add_sweep(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(
      app, exit_code, "sweep", "Try many values of a scenario's keys and score them", kSweepExamples, sweep);
  command.add_option("file", request.file, "YAML file of a sweep or a scenario")->required();
  command.add_option("values", request.arguments, "values to try (gaitslam config --keys)")
      ->option_text("key=a,b,c ... key={from: a, to: b} ...");
  add_seeds(command, request.seeds, "seeds to use instead of the file's");
  command.add_option("--samples", request.samples, "samples for ranges without points (default 16)")
      ->check(CLI::Range(std::size_t{1}, trials::kMostTrials));
  add_backend_options(command, request.backend);
  add_without(command, request.changes);
  add_with(command, request.changes);
  add_out(command, request);
  command.add_flag("--dry-run", request.dry_run, "print what would be tried and simulated, then stop");
}

void add_tune(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "tune", "Search for the filter parameters that fit recordings best",
                  kTuneExamples, tune_by);
  command.add_option("spec", request.spec, "YAML file of the tuning")->required();
  add_backend_options(command, request.backend);
  command.add_option("--out", request.out, "folder for the results");
}

/// The hidden command that runs the trials listed in a file.
void add_trials(CLI::App& app, int& exit_code) {
  auto [command, request] = add_command(app, exit_code, "trials", "Run the trials of a file", "", run_listed);
  command.group("");
  command.add_option("jobs", request.jobs)->required();
  command.add_option("records", request.records)->required();
  add_batch_member(command, request.batch);
}

}  // namespace cli
