#include "tools/cli/jobs/results.h"

#include <fmt/ranges.h>

#include <iostream>
#include <set>

#include "sim/files/hash.h"
#include "sim/scenario/keys.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

void report_damage(const std::string& what) {
  std::cerr << fmt::format("gaitslam: ignored a damaged recording in the cache: {}\n", what);
}

/// Returns a key of everything that a result depends on.
std::string key_of(const ResultJob& job, const std::string& models_hash, bool cached) {
  const std::string recording = job.recording ? fs::weakly_canonical(*job.recording).string() : "";
  return result::job_key({program_identity(), models_hash, cached ? "cached" : "",
                          inputs_of(job.read.scenario), job.result(),
                          fmt::format("{}", fmt::join(job.command, "\n")), recording, job.program.string()});
}

Job process_of(const ResultJob& job, const fs::path& out, const ResultOptions& options,
               const std::string& models_hash) {
  Job process{.key = key_of(job, models_hash, options.cached),
              .seed = job.seed(),
              .words = job.command,
              .scenario = scenario::to_yaml(job.read.scenario),
              .origin = job.read.origin,
              .cost = job.cost,
              .program = job.program};
  std::vector<std::string>& words = process.words;
  if (!job.command.empty())
    process.scenario.clear(),
        words.insert(words.end(), {"--out", (job.program.empty() ? out : out / job.folder).string()});
  else if (job.recording)
    words = {"replay",     job.recording->string(), "--out", (out / job.result()).string(), "--scenario",
             kScenarioFile};
  else
    words = {"run", kScenarioFile, "--out", (out / job.folder).string()};
  if (options.cached && !job.recording) words.emplace_back("--cached");
  words.emplace_back("--force");
  return process;
}

std::string scenario_difference(const scenario::Scenario& there, const scenario::Scenario& here) {
  const auto any = [](std::string_view key) { return key != "seed"; };
  if (const auto key = scenario::first_difference(there, here, any))
    return fmt::format("{} is {} there and {} here", key->key, key->recorded, key->now);
  const auto key = scenario::first_difference(here, there, any);
  return key ? fmt::format("{} is {} here and {} there", key->key, key->recorded, key->now)
             : "its limits or name differ";
}

/// Returns what distinguishes a result from the job's new one, or nothing if they are the same. If
/// the sources were modified since the revision, the result must be newer than the program.
std::optional<std::string> difference(const fs::path& folder, const ResultJob& job,
                                      const std::string& models_hash) try {
  if (!job.program.empty() && result::is_result(folder)) return std::nullopt;
  const result::About made = result::read_about(folder / "about.json");
  const std::string revision = kRevision;
  const result::Provenance there = result::provenance_of(folder),
                           here = result::provenance_of(job.read.scenario, revision,
                                                        job.recording ? made.models : models_hash);
  const std::string recording =
      job.recording ? result::read_about(*job.recording / "about.json").recording : made.recording;
  if (there.scenario != here.scenario)
    return scenario_difference(scenario::read_scenario(folder / "scenario.yaml").scenario, job.read.scenario);
  for (const auto& [what, a, b] : {std::tuple("revision", there.revision, here.revision),
                                   {"models' hash", there.models, here.models},
                                   {"programs' hash", there.estimator_files, here.estimator_files},
                                   {"recording's hash", made.recording, recording},
                                   {"seed", std::to_string(made.seed), std::to_string(job.seed())}})
    if (a != b) return fmt::format("its {} is {}, not {}", what, a, b);
  if ((revision.ends_with("+") || revision == "unknown") &&
      fs::last_write_time(folder / "about.json") <= fs::last_write_time("/proc/self/exe"))
    return "another build made it";
  return std::nullopt;
} catch (const std::exception& damage) {
  return damage.what();
}

/// Returns when a result was made.
fs::file_time_type time_of(const fs::path& folder) {
  std::error_code none;
  return fs::last_write_time(folder / "about.json", none);
}

/// True if the same program would reproduce the result bit for bit.
bool is_repeatable(const scenario::Scenario& scenario) {
  using programs::Source;
  return scenario.estimator.source == Source::built_in && scenario.controller.source == Source::built_in &&
         scenario.estimator_time.model != scenario::TimeModel::measured;
}

[[noreturn]] void fail_as_other(const fs::path& folder, const std::string& how) {
  throw UsageError("{}: exists, but {}; --force replaces it, --out names another folder", folder.string(),
                   how);
}

void print_complaints(const std::vector<ResultJob>& jobs, const std::vector<ResultEnd>& ends) {
  std::map<std::pair<std::string, std::string>, std::vector<std::uint64_t>> seeds;
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (ends[i].exit_code > 1) seeds[{jobs[i].folder, ends[i].complaint}].push_back(jobs[i].seed());
  static std::set<std::string> shown;  // the last lines of failed programs, which name the exceptions
  for (const auto& [what, of] : seeds) {
    const auto& [folder, complaint] = what;
    const std::size_t end = complaint.find(result::kLastLines);
    const bool is_new =
        end == complaint.npos ||
        shown.insert(folder + complaint.substr(std::max(end + 1, complaint.rfind(" | ") + 1))).second;
    std::cerr << fmt::format("{}{}seed{} {}: {}", folder, folder.empty() ? "" : " ", of.size() > 1 ? "s" : "",
                             fmt::join(of, ", "), is_new ? complaint : complaint.substr(0, end) + "\n");
  }
}

}  // namespace

std::vector<std::uint64_t> seeds_beside(const ResultJob& job, const fs::path& root, const fs::path& models,
                                        bool force) {
  const std::string models_hash = scenario::models_hash(models);
  std::vector<std::uint64_t> seeds = result::seeds_in(root);
  std::erase_if(seeds, [&](std::uint64_t seed) {
    ResultJob beside = job;
    beside.read.scenario.seed = seed;
    const auto other = difference(root / beside.result(), beside, models_hash);
    if (other && !force) fail_as_other(root / beside.result(), *other);
    return other.has_value();
  });
  return seeds;
}

Recordings::Recordings(fs::path models)
    : models_(std::move(models)),
      models_hash_(scenario::models_hash(models_)),
      program_(recording_identity()),
      cache_(recording::cache_place()) {}

std::string Recordings::key(const scenario::Scenario& scenario) const {
  std::string programs = program_;
  // A walk steered by the estimate depends on the estimator and its inputs.
  if (scenario.walk.steering.by == walking::SteeredBy::estimate)
    programs += program_identity() + programs::files_identity(scenario.estimator);
  return scenario::recording_key(scenario, models_hash_, programs);
}

std::optional<recording::CachedRecording> Recordings::find(const scenario::Scenario& scenario) const {
  return cache_.find(key(scenario), report_damage);
}

recording::CachedRecording Recordings::get(const scenario::ReadScenario& read,
                                           const result::Progress& progress) const {
  const auto walk = [&](const fs::path& folder) {
    scenario::ReadScenario recorded = read;
    if (read.scenario.walk.steering.by != walking::SteeredBy::estimate)
      recorded.scenario.slam.reset(), recorded.scenario.sessions.clear();
    run_live(recorded, result_place(folder, models_hash_, models_), progress);
  };
  return cache_.get(key(read.scenario), walk, report_damage);
}

std::vector<Recordings::Made> Recordings::make(const std::vector<scenario::ReadScenario>& scenarios,
                                               Backend backend) const {
  std::vector<Job> missing;
  std::vector<Made> all;
  std::map<std::string, std::size_t> index_of;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    const scenario::Scenario& scenario = scenarios[i].scenario;
    const auto found = find(scenario);
    all.push_back({found ? found->folder : fs::path()});
    if (found || !index_of.emplace(key(scenario), i).second) continue;
    missing.push_back({.key = key(scenario),
                       .seed = scenario.seed,
                       .words = {"record", kScenarioFile},
                       .scenario = scenario::to_yaml(scenario),
                       .origin = scenarios[i].origin});
  }
  if (missing.empty()) return all;
  require_simulator();
  run_jobs(missing, backend, fmt::format("{} recordings", missing.size()),
           [&](const std::vector<JobRecord>& records) {
             for (const JobRecord& record : records) {
               const std::size_t i = index_of.at(record.key);
               const auto found = find(scenarios[i].scenario);
               all[i] = {found ? found->folder : fs::path(), true, record};
             }
           });
  return all;
}

std::string ResultJob::result() const { return (fs::path(folder) / fmt::format("seed-{}", seed())).string(); }

std::vector<ResultJob> jobs_of_seeds(const ResultJob& job, const std::vector<std::uint64_t>& seeds) {
  std::vector<ResultJob> jobs(seeds.size(), job);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    jobs[i].read.scenario.seed = seeds[i];
    if (job.recording) jobs[i].recording = *job.recording / fmt::format("seed-{}", seeds[i]);
  }
  return jobs;
}

std::vector<ResultEnd> make_results(const std::vector<ResultJob>& jobs, const OutFolder& out,
                                    const ResultOptions& options) {
  const std::string models_hash = options.models.empty() ? "" : scenario::models_hash(options.models);
  std::vector<ResultEnd> ends(jobs.size());
  std::vector<Job> left;
  std::map<std::string, std::pair<std::size_t, fs::file_time_type>>
      index_of;  // and the time of the old result
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const fs::path folder = out.path() / jobs[i].result();
    files::require_replaceable(folder);
    const auto other = difference(folder, jobs[i], models_hash);
    ends[i].finished = !other && (!options.force || is_repeatable(jobs[i].read.scenario));
    if (ends[i].finished) continue;
    if (files::has_marker(folder) && !options.force) fail_as_other(folder, *other);
    left.push_back(process_of(jobs[i], out.path(), options, models_hash));
    index_of[left.back().key] = {i, time_of(folder)};
  }
  if (left.size() < jobs.size())
    text_out() << files::counted(jobs.size() - left.size(), "result") << " finished before\n" << std::flush;
  Backend backend = options.backend;
  backend.spool = out.path() / ".slurm";
  run_jobs(left, backend, options.title, [&](const std::vector<JobRecord>& records) {
    for (const JobRecord& record : records) {
      const auto& [i, old] = index_of.at(record.key);
      const fs::path folder = out.path() / jobs[i].result();
      const bool ran = exit_code_of(record) <= 1 || time_of(folder) != old;
      ends[i] = {ran && !difference(folder, jobs[i], models_hash), exit_code_of(record), record.cause};
    }
  });
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (options.must_start && ends[i].exit_code == 2)
      throw UsageError("{}seed {}: {}", jobs[i].program.empty() ? "" : jobs[i].program.string() + ": ",
                       jobs[i].seed(), ends[i].complaint);
  print_complaints(jobs, ends);
  return ends;
}

std::vector<result::SeedScore> read_scores(const std::vector<ResultJob>& jobs,
                                           const std::vector<ResultEnd>& ends, const fs::path& out) {
  std::vector<result::SeedScore> scores;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    scores.push_back(ends[i].finished ? result::read_result(out / jobs[i].result())
                                      : result::without_score(jobs[i].seed(), ends[i].exit_code));
    if (!ends[i].finished) scores.back().last_lines = files::sanitize(ends[i].complaint);
  }
  return scores;
}

std::string inputs_of(const scenario::Scenario& scenario) {
  return scenario::to_yaml(scenario) + programs::files_identity(scenario.estimator) +
         programs::files_identity(scenario.controller);
}

}  // namespace cli
