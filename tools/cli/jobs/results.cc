#include "tools/cli/jobs/results.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <set>

#include "sim/files/atomic_file.h"
#include "sim/files/hash.h"
#include "sim/files/text.h"
#include "sim/regression/suite.h"
#include "sim/result/score_file.h"
#include "sim/scenario/keys.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/live.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

void report_damage(const std::string& what) {
  std::cerr << fmt::format("gaitslam: ignored a damaged recording in the cache: {}\n", what);
}

/// Empty if the file is missing or damaged: the result is then made again.
result::About about(const fs::path& folder) try {
  return result::read_about(folder / "about.json");
} catch (const files::FileError&) {
  return {};
}

CommandLine line_of(const ResultJob& job, const fs::path& out, const ResultOptions& options,
                    FrozenScenarios& frozen) {
  std::vector<std::string> words;
  const auto add = [&](const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
  };
  if (!job.command.empty()) {
    add(job.command);
    add({"--out", out.string(), "--force"});
    return {words, job.cost};
  }
  if (job.recording)
    add({"replay", job.recording->string(), "--out", (out / job.result()).string(), "--scenario"});
  else
    add({"run", "--out", (out / job.folder).string(), "--models", options.models.string()});
  add(frozen.words(job.read.scenario.name, job.read));
  add({fmt::format("seed={}", job.seed()), "--force"});
  if (options.cached && !job.recording) words.emplace_back("--cached");
  return {words, job.cost};
}

/// True if this program made the result from the job's scenario, seed, and recording or models. If the
/// sources differ from the revision, also the times of the files count.
bool is_finished(const fs::path& folder, const ResultJob& job, const std::string& models_hash) {
  for (const char* file : {"score.json", "about.json", "scenario.yaml"})
    if (!fs::is_regular_file(folder / file)) return false;
  const result::About made = about(folder);
  const std::string revision = kRevision;
  const bool exact = !revision.ends_with("+") && revision != "unknown";
  if (made.revision != revision ||
      (!exact && fs::last_write_time(folder / "about.json") <= fs::last_write_time("/proc/self/exe")) ||
      files::read_text(folder / "scenario.yaml") != scenario::to_yaml(job.read.scenario))
    return false;
  if (!job.recording) return made.models == models_hash;
  const std::string recorded = about(*job.recording).recording;  // empty before the walk was recorded
  return !recorded.empty() && recorded == made.recording;
}

/// Distinguishes a folder from its replacement: device and inode, or nullopt if it does not exist.
using Identity = std::optional<std::pair<dev_t, ino_t>>;

Identity identity_of(const fs::path& folder) {
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0) return std::nullopt;
  return std::pair(status.st_dev, status.st_ino);
}

/// The indices of the jobs to run. On Slurm all of them, because the job array knows what has ended.
std::vector<std::size_t> unfinished(const std::vector<ResultJob>& jobs, const OutFolder& out,
                                    const ResultOptions& options) {
  const std::string models_hash = options.models.empty() ? "" : scenario::models_hash(options.models);
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (options.backend.slurm() ||
        !(options.counts_older || (out.log() && out.log()->find(jobs[i].result()))) ||
        !is_finished(out.path() / jobs[i].result(), jobs[i], models_hash))
      left.push_back(i);
  if (left.size() < jobs.size())
    text_out() << files::counted(jobs.size() - left.size(), "result") << " finished before\n" << std::flush;
  return left;
}

/// Moves these folders of `root` into its first folder earlier-<n> that does not exist yet.
void set_aside(const fs::path& root, const std::vector<std::string>& names) {
  if (names.empty()) return;
  int n = 1;
  while (fs::exists(fs::symlink_status(root / fmt::format("earlier-{}", n)))) ++n;
  const fs::path aside = root / fmt::format("earlier-{}", n);
  fs::create_directory(aside);
  for (const std::string& name : names) fs::rename(root / name, aside / name);
  text_out() << fmt::format("results of an earlier command are now in {}: {}\n", aside.string(),
                            fmt::join(names, ", "));
}

void move_stale_results(const std::vector<ResultJob>& jobs, const fs::path& out,
                        std::map<std::string, std::vector<std::string>> stale, bool keep_other_seeds) {
  std::map<std::string, std::vector<std::uint64_t>> seeds;
  for (const ResultJob& job : jobs) seeds[job.folder].push_back(job.seed());
  for (const auto& [folder, of] : seeds) {
    std::vector<std::string>& names = stale[folder];
    if (!keep_other_seeds)
      for (std::string& name : results_of_other_seeds(out / folder, of)) names.push_back(std::move(name));
    set_aside(out / folder, names);
    files::remove_leftovers(out / folder);  // of processes that crashed
  }
}

void print_complaints(const std::vector<ResultJob>& jobs, const std::vector<Exited>& ended) {
  std::map<std::pair<std::string, std::string>, std::vector<std::uint64_t>> seeds;
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (ended[i].exit_code > 1) seeds[{jobs[i].folder, ended[i].complaint}].push_back(jobs[i].seed());
  for (const auto& [what, of] : seeds)
    std::cerr << fmt::format("{}{}seed{} {}: {}", what.first, what.first.empty() ? "" : " ",
                             of.size() > 1 ? "s" : "", fmt::join(of, ", "), what.second);
}

}  // namespace

std::vector<std::string> results_of_other_seeds(const fs::path& root,
                                                const std::vector<std::uint64_t>& seeds) {
  std::set<std::uint64_t> others;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(root, none)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with("seed-") || !fs::exists(entry.path() / "score.json", none)) continue;
    const auto seed = files::parse_number<std::uint64_t>(std::string_view(name).substr(5));
    if (!seed || name != fmt::format("seed-{}", *seed)) continue;  // the program writes no seed-07
    if (std::ranges::count(seeds, *seed) == 0) others.insert(*seed);
  }
  std::vector<std::string> names;
  for (const std::uint64_t seed : others) names.push_back(fmt::format("seed-{}", seed));
  return names;
}

Recordings::Recordings(fs::path models)
    : models_(std::move(models)),
      models_hash_(scenario::models_hash(models_)),
      program_(recording_identity()),
      cache_(recording::cache_place()) {}

std::string Recordings::key(const scenario::Scenario& scenario) const {
  std::string programs = program_;
  // The estimator and its inputs shape a walk that the estimate steers.
  if (scenario.walk.steering.by == walking::SteeredBy::estimate)
    programs += program_identity() + estimators::estimator_files_identity(scenario.estimator);
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
                                               const Backend& backend) const {
  FrozenScenarios frozen(backend);
  CommandLines lines;
  std::vector<Made> all;
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    const auto found = find(scenarios[i].scenario);
    all.push_back({found ? found->folder : ""});
    if (found) continue;
    lines.push_back({{"record", "--models", fs::absolute(models_).string()}});
    for (std::string& word : frozen.words(key(scenarios[i].scenario), scenarios[i]))
      lines.back().words.push_back(std::move(word));
    missing.push_back(i);
  }
  if (missing.empty()) return all;
  require_simulator();
  ProgressLine progress(fmt::format("{} recordings", missing.size()));
  const std::vector<Exited> ended = run_all(lines, backend, [&](double part) { progress.show(part); });
  for (std::size_t k = 0; k < missing.size(); ++k) {
    const auto found = find(scenarios[missing[k]].scenario);
    all[missing[k]] = {found ? found->folder : "", true, ended[k]};
  }
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

std::vector<Exited> make_results(const std::vector<ResultJob>& jobs, const OutFolder& out,
                                 const ResultOptions& options) {
  const auto folder_of = [&](std::size_t i) { return out.path() / jobs[i].result(); };
  for (std::size_t i = 0; i < jobs.size(); ++i) files::require_replaceable(folder_of(i));
  const std::vector<std::size_t> left = unfinished(jobs, out, options);
  Backend backend = options.backend;
  backend.spool = out.path() / ".slurm";
  FrozenScenarios frozen(backend);
  CommandLines lines;
  std::vector<Identity> before;
  for (const std::size_t i : left) {
    before.push_back(identity_of(folder_of(i)));
    lines.push_back(line_of(jobs[i], out.path(), options, frozen));
  }
  std::optional<ProgressLine> line;
  if (!left.empty()) line.emplace(options.title);
  const OnEnded on_ended = [&](std::size_t k) {
    const Identity now = identity_of(folder_of(left[k]));
    if (out.log() && now && now != before[k])
      out.log()->add({jobs[left[k]].result(), jobs[left[k]].seed(), "finished", "", {}});
  };
  const std::vector<Exited> ended = run_all(
      lines, backend, [&](double part) { line->show(part); }, on_ended);
  line.reset();
  std::vector<Exited> all(jobs.size());
  std::map<std::string, std::vector<std::string>> stale;
  for (std::size_t k = 0; k < left.size(); ++k) {
    const ResultJob& job = jobs[left[k]];
    const fs::path folder = folder_of(left[k]);
    all[left[k]] = ended[k];
    if (!before[k] || identity_of(folder) != before[k]) continue;
    // On Slurm a killed command may have started the job: its result is then older than this process.
    if (!backend.slurm() || !fs::exists(folder / "scenario.yaml") ||
        files::read_text(folder / "scenario.yaml") != scenario::to_yaml(job.read.scenario))
      stale[job.folder].push_back(folder.filename());
  }
  move_stale_results(jobs, out.path(), std::move(stale), options.keeps_other_seeds);
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (options.must_start && all[i].exit_code == 2)
      throw UsageError("seed {}: {}", jobs[i].seed(), all[i].complaint);
  print_complaints(jobs, all);
  return all;
}

std::vector<result::SeedScore> read_scores(const std::vector<ResultJob>& jobs,
                                           const std::vector<Exited>& ended, const fs::path& out) {
  std::vector<result::SeedScore> scores;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const fs::path folder = out / jobs[i].result();
    const bool there = fs::exists(folder / "score.json");
    scores.push_back(there ? regression::read_result(folder)
                           : result::without_score(jobs[i].seed(), ended[i].exit_code));
    if (!there) scores.back().last_lines = ended[i].complaint;
  }
  return scores;
}

std::string inputs_of(const scenario::Scenario& scenario) {
  return scenario::to_yaml(scenario) + estimators::estimator_files_identity(scenario.estimator);
}

OutUse resumable(const std::vector<ResultJob>& jobs, const fs::path& models, bool cached) {
  files::Hash hash;
  for (const std::string& part : {program_identity(), models.empty() ? "" : scenario::models_hash(models),
                                  std::string(cached ? "cached" : "")})
    hash.add_part(part);
  OutUse use;
  for (const ResultJob& job : jobs) {
    use.results.push_back(job.result());
    hash.add_part(inputs_of(job.read.scenario));
    hash.add_part(use.results.back());
    for (const std::string& word : job.command) hash.add_part(word);
    hash.add_part(job.recording ? fs::weakly_canonical(*job.recording).string() : "");
  }
  use.identity = hash.hex();
  return use;
}

}  // namespace cli
