#include "tools/cli/jobs/results.h"

#include <fmt/ranges.h>

#include <iostream>

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

/// Returns an empty record if the file is missing or damaged; the result is then made again.
result::About about(const fs::path& folder) try {
  return result::read_about(folder / "about.json");
} catch (const files::FileError&) {
  return {};
}

/// Returns a key of everything that a result depends on.
std::string key_of(const ResultJob& job, const std::string& models_hash, bool cached) {
  const std::string recording = job.recording ? fs::weakly_canonical(*job.recording).string() : "";
  return result::job_key({program_identity(), models_hash, cached ? "cached" : "",
                          inputs_of(job.read.scenario), job.result(),
                          fmt::format("{}", fmt::join(job.command, "\n")), recording});
}

Job process_of(const ResultJob& job, const fs::path& out, const ResultOptions& options,
               const std::string& models_hash) {
  Job process{.key = key_of(job, models_hash, options.cached),
              .seed = job.seed(),
              .words = job.command,
              .scenario = scenario::to_yaml(job.read.scenario),
              .origin = job.read.origin,
              .folder = out / job.result(),
              .cost = job.cost};
  std::vector<std::string>& words = process.words;
  if (!job.command.empty())
    process.scenario.clear(), words.insert(words.end(), {"--out", out.string()});
  else if (job.recording)
    words = {"replay",     job.recording->string(), "--out", process.folder.string(), "--scenario",
             kScenarioFile};
  else
    words = {"run", kScenarioFile, "--out", (out / job.folder).string()};
  if (options.cached && !job.recording) words.emplace_back("--cached");
  words.emplace_back("--force");
  return process;
}

/// True if this program made the result from the job's scenario, seed, estimator files, and recording or
/// models. If the sources were modified since the revision, file times are compared as well.
bool is_finished(const fs::path& folder, const ResultJob& job, const std::string& models_hash) try {
  if (!result::is_result(folder)) return false;
  const result::About made = about(folder);
  const std::string revision = kRevision;
  const bool exact = !revision.ends_with("+") && revision != "unknown";
  if (made.seed != job.seed() ||
      (!exact && fs::last_write_time(folder / "about.json") <= fs::last_write_time("/proc/self/exe")) ||
      result::provenance_of(folder) !=
          result::provenance_of(job.read.scenario, revision, job.recording ? made.models : models_hash))
    return false;
  const std::string recorded = job.recording ? about(*job.recording).recording : "";  // empty before the walk
  return !job.recording || (!recorded.empty() && recorded == made.recording);
} catch (const std::exception&) {  // incomplete
  return false;
}

/// Returns the indices of the jobs to run.
std::vector<std::size_t> unfinished(const std::vector<ResultJob>& jobs, const OutFolder& out,
                                    const ResultOptions& options, const std::string& models_hash) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (!(options.counts_older || (out.log() && out.log()->find(jobs[i].result()))) ||
        !is_finished(out.path() / jobs[i].result(), jobs[i], models_hash))
      left.push_back(i);
  if (left.size() < jobs.size())
    text_out() << files::counted(jobs.size() - left.size(), "result") << " finished before\n" << std::flush;
  return left;
}

/// Sets aside outdated results, and those of seeds that are neither in the jobs nor to be kept.
void move_stale_results(const std::vector<ResultJob>& jobs, const fs::path& out,
                        std::map<std::string, std::vector<std::string>> stale, const ResultOptions& options) {
  std::map<std::string, std::vector<std::uint64_t>> seeds;
  for (const ResultJob& job : jobs) seeds[job.folder].push_back(job.seed());
  for (auto& [folder, kept] : seeds) {
    std::vector<std::string>& names = stale[folder];
    kept.insert(kept.end(), options.kept_seeds.begin(), options.kept_seeds.end());
    for (const std::uint64_t seed : result::seeds_in(out / folder))
      if (!options.keeps_other_seeds && std::ranges::count(kept, seed) == 0)
        names.push_back(fmt::format("seed-{}", seed));
    if (const auto earlier = files::set_aside(out / folder, names))
      text_out() << fmt::format("results of an earlier command are now in {}: {}\n", earlier->string(),
                                fmt::join(names, ", "));
    files::remove_leftovers(out / folder);  // of processes that crashed
  }
}

void print_complaints(const std::vector<ResultJob>& jobs, const std::vector<JobRecord>& ended) {
  std::map<std::pair<std::string, std::string>, std::vector<std::uint64_t>> seeds;
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (exit_code_of(ended[i]) > 1) seeds[{jobs[i].folder, ended[i].cause}].push_back(jobs[i].seed());
  for (const auto& [what, of] : seeds)
    std::cerr << fmt::format("{}{}seed{} {}: {}", what.first, what.first.empty() ? "" : " ",
                             of.size() > 1 ? "s" : "", fmt::join(of, ", "), what.second);
}

}  // namespace

std::vector<std::uint64_t> finished_beside(const std::vector<ResultJob>& jobs, const fs::path& root,
                                           const fs::path& models) {
  const std::string models_hash = scenario::models_hash(models);
  std::vector<std::uint64_t> seeds = result::seeds_in(root);
  std::erase_if(seeds, [&](std::uint64_t seed) {
    ResultJob beside = jobs.front();
    beside.read.scenario.seed = seed;
    return std::ranges::count(jobs, seed, &ResultJob::seed) > 0 ||
           !is_finished(root / beside.result(), beside, models_hash);
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
    if (read.scenario.walk.steering.by != walking::SteeredBy::estimate) recorded.scenario.slam.reset();
    run_live(recorded, result_place(folder, models_hash_, models_), progress);
  };
  return cache_.get(key(read.scenario), {read.scenario.name, read.scenario.seed}, walk, report_damage);
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
  run_jobs(missing, backend, fmt::format("{} recordings", missing.size()), [&](const JobRecord& record) {
    const std::size_t i = index_of.at(record.key);
    const auto found = find(scenarios[i].scenario);
    all[i] = {found ? found->folder : fs::path(), true, record};
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

std::vector<JobRecord> make_results(const std::vector<ResultJob>& jobs, const OutFolder& out,
                                    const ResultOptions& options) {
  for (const ResultJob& job : jobs) files::require_replaceable(out.path() / job.result());
  const std::string models_hash = options.models.empty() ? "" : scenario::models_hash(options.models);
  std::vector<Job> left;
  std::map<std::string, std::size_t> index_of;
  for (const std::size_t i : unfinished(jobs, out, options, models_hash)) {
    left.push_back(process_of(jobs[i], out.path(), options, models_hash));
    index_of[left.back().key] = i;
  }
  Backend backend = options.backend;
  backend.spool = out.path() / ".slurm";
  std::vector<JobRecord> all(jobs.size());
  std::map<std::string, std::vector<std::string>> stale;
  run_jobs(left, backend, options.title, [&](const JobRecord& record) {
    const std::size_t i = index_of.at(record.key);
    all[i] = record;
    if (record.ending != kFinished && fs::exists(out.path() / jobs[i].result()))
      stale[jobs[i].folder].push_back(fs::path(jobs[i].result()).filename());
    else if (out.log() && record.ending == kFinished)
      out.log()->add({jobs[i].result(), jobs[i].seed(), kFinished, "", {}});
  });
  move_stale_results(jobs, out.path(), std::move(stale), options);
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (options.must_start && exit_code_of(all[i]) == 2)
      throw UsageError("seed {}: {}", jobs[i].seed(), all[i].cause);
  print_complaints(jobs, all);
  return all;
}

std::vector<result::SeedScore> read_scores(const std::vector<ResultJob>& jobs,
                                           const std::vector<JobRecord>& ended, const fs::path& out) {
  std::vector<result::SeedScore> scores;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const fs::path folder = out / jobs[i].result();
    const bool there = result::is_result(folder);
    scores.push_back(there ? result::read_result(folder)
                           : result::without_score(jobs[i].seed(), exit_code_of(ended[i])));
    if (!there) scores.back().last_lines = files::sanitize(ended[i].cause);
  }
  return scores;
}

std::string inputs_of(const scenario::Scenario& scenario) {
  return scenario::to_yaml(scenario) + programs::files_identity(scenario.estimator) +
         programs::files_identity(scenario.controller);
}

OutUse resumable(const std::vector<ResultJob>& jobs, const fs::path& models, bool cached) {
  const std::string models_hash = models.empty() ? "" : scenario::models_hash(models);
  files::Hash hash;
  OutUse use;
  for (const ResultJob& job : jobs) {
    use.results.push_back(job.result());
    hash.add_part(key_of(job, models_hash, cached));
  }
  use.identity = hash.hex();
  return use;
}

}  // namespace cli
