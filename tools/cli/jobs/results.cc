#include "tools/cli/jobs/results.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "sim/files/atomic_file.h"
#include "sim/files/hash.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/regression/results.h"
#include "sim/result/score_file.h"
#include "sim/scenario/recording_key.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/jobs/terminal.h"
#include "tools/cli/shared/version.h"

namespace cli {
namespace {

namespace files = sim::files;
namespace result = sim::result;
namespace scenario = sim::scenario;

std::string seed_name(std::uint64_t seed) { return fmt::format("seed-{}", seed); }

/// Empty if the file is missing or damaged: the result is then made again.
result::About about(const fs::path& folder) try {
  return result::read_about(folder / "about.json");
} catch (const files::FileError&) {
  return {};
}

/// Compares the revision, and if the sources differ from it also the times of the files.
bool is_by_this_program(const fs::path& folder) {
  if (about(folder).revision != kRevision) return false;
  const bool exact = !std::string(kRevision).ends_with("+") && kRevision != std::string("unknown");
  return exact || fs::last_write_time(folder / "about.json") > fs::last_write_time("/proc/self/exe");
}

/// Files that the processes of the jobs read: each scenario as it is now, so that later edits change no
/// queued job, and the origins of its keys.
class FrozenScenarios {
 public:
  explicit FrozenScenarios(const Backend& backend) : shared_(backend) {}

  /// The arguments for the job's scenario: `option` (may be empty) and the file, seed, and origins.
  std::vector<std::string> arguments(const ResultJob& job, const std::string& option) {
    const std::string& name = job.read.scenario.name;
    if (!files_.contains(name)) {
      files_[name] = {(shared_ / (name + ".yaml")).string(), (shared_ / (name + ".set_by.json")).string()};
      files::write_text(files_[name].first, scenario::to_yaml(job.read.scenario));
      files::write_text(files_[name].second, files::json_text(nlohmann::ordered_json(job.read.origin)));
    }
    std::vector<std::string> words;
    if (!option.empty()) words.push_back(option);
    words.insert(words.end(),
                 {files_[name].first, fmt::format("seed={}", job.seed()), "--set-by", files_[name].second});
    return words;
  }

 private:
  SharedFolder shared_;
  std::map<std::string, std::pair<std::string, std::string>> files_;  ///< by the scenario's name
};

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
    add({"replay", job.recording->string(), "--out", (out / job.result()).string()});
  else
    add({"run", "--out", (out / job.folder).string(), "--models", options.models.string()});
  add(frozen.arguments(job, job.recording ? "--scenario" : ""));
  if (options.cached && !job.recording) words.emplace_back("--cached");
  words.emplace_back("--force");
  add(options.more);
  return {words, job.cost};
}

/// Distinguishes a folder from its replacement: device and inode, or nullopt if it does not exist.
using Identity = std::optional<std::pair<dev_t, ino_t>>;

Identity identity_of(const fs::path& folder) {
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0) return std::nullopt;
  return std::pair(status.st_dev, status.st_ino);
}

/// On Slurm a killed process may have started the job: its result is then older than this process.
bool is_of_killed_command(const fs::path& folder, const ResultJob& job, const Backend& backend) {
  return backend.slurm() && fs::exists(folder / "scenario.yaml") &&
         files::read_text(folder / "scenario.yaml") == scenario::to_yaml(job.read.scenario);
}

/// The indices of the jobs to run. On Slurm all of them, because the job array knows what has ended.
std::vector<std::size_t> unfinished(const std::vector<ResultJob>& jobs, const OutFolder& out,
                                    const ResultOptions& options) {
  std::vector<std::size_t> left(jobs.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  if (options.backend.slurm()) return left;
  const std::string models_hash = options.models.empty() ? "" : scenario::models_hash(options.models);
  std::erase_if(left, [&](std::size_t i) {
    return (options.counts_older || out.has_made(jobs[i].result())) &&
           is_finished(out.path() / jobs[i].result(), jobs[i], models_hash);
  });
  if (left.size() < jobs.size())
    text_out() << files::counted(jobs.size() - left.size(), "result") << " finished before\n" << std::flush;
  return left;
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

}  // namespace

std::string ResultJob::result() const { return (fs::path(folder) / seed_name(seed())).string(); }

std::vector<ResultJob> jobs_of_seeds(const ResultJob& job, const std::vector<std::uint64_t>& seeds) {
  std::vector<ResultJob> jobs(seeds.size(), job);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    jobs[i].read.scenario.seed = seeds[i];
    if (job.recording) jobs[i].recording = *job.recording / seed_name(seeds[i]);
  }
  return jobs;
}

std::vector<std::string> results_of(const std::vector<ResultJob>& jobs) {
  std::vector<std::string> results;
  for (const ResultJob& job : jobs) results.push_back(job.result());
  return results;
}

std::vector<Ended> make_results(const std::vector<ResultJob>& jobs, const OutFolder& out,
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
    if (now && now != before[k]) out.note_made(jobs[left[k]].result());
  };
  const std::vector<Ended> ended = run_all(
      lines, backend, [&](double part) { line->show(part); }, on_ended);
  line.reset();
  std::vector<Ended> all(jobs.size());
  std::map<std::string, std::vector<std::string>> stale;
  for (std::size_t k = 0; k < left.size(); ++k) {
    const ResultJob& job = jobs[left[k]];
    const fs::path folder = folder_of(left[k]);
    all[left[k]] = ended[k];
    if (before[k] && identity_of(folder) == before[k] && !is_of_killed_command(folder, job, backend))
      stale[job.folder].push_back(folder.filename());
  }
  move_stale_results(jobs, out.path(), std::move(stale), options.keeps_other_seeds);
  return all;
}

std::vector<result::SeedScore> read_scores(const std::vector<ResultJob>& jobs,
                                           const std::vector<Ended>& ended, const fs::path& out) {
  std::vector<result::SeedScore> scores;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const fs::path folder = out / jobs[i].result();
    const bool there = fs::exists(folder / "score.json");
    scores.push_back(there
                         ? sim::regression::read_result(folder)
                         : result::read_seed_score(out / jobs[i].folder, jobs[i].seed(), ended[i].exit_code));
    if (!there) scores.back().last_lines = ended[i].complaint;
  }
  return scores;
}

void print_complaints(const std::vector<ResultJob>& jobs, const std::vector<Ended>& ended) {
  std::map<std::pair<std::string, std::string>, std::vector<std::uint64_t>> seeds;
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (ended[i].exit_code > 1) seeds[{jobs[i].folder, ended[i].complaint}].push_back(jobs[i].seed());
  for (const auto& [what, of] : seeds)
    std::cerr << fmt::format("{}{}seed{} {}: {}", what.first, what.first.empty() ? "" : " ",
                             of.size() > 1 ? "s" : "", fmt::join(of, ", "), what.second);
}

bool is_finished(const fs::path& folder, const ResultJob& job, const std::string& models_hash) {
  for (const char* file : {"score.json", "about.json", "scenario.yaml"})
    if (!fs::is_regular_file(folder / file)) return false;
  if (!is_by_this_program(folder) ||
      files::read_text(folder / "scenario.yaml") != scenario::to_yaml(job.read.scenario))
    return false;
  if (!job.recording) return about(folder).models == models_hash;
  const std::string recorded = about(*job.recording).recording;  // empty before the walk was recorded
  return !recorded.empty() && recorded == about(folder).recording;
}

std::string inputs_of(const scenario::Scenario& scenario) {
  return scenario::to_yaml(scenario) + sim::estimators::estimator_files_identity(scenario.estimator);
}

std::string identity_of(const std::vector<ResultJob>& jobs, const std::vector<std::string>& inputs) {
  files::Hash hash;
  hash.add_part(program_identity());
  for (const std::string& input : inputs) hash.add_part(input);
  const ResultJob* last = nullptr;
  for (const ResultJob& job : jobs) {
    if (!last || last->read.scenario.name != job.read.scenario.name) {
      scenario::Scenario scenario = job.read.scenario;
      scenario.seed = 0;
      hash.add_part(inputs_of(scenario));
    }
    hash.add_part(job.result());
    hash.add_part(job.recording ? fs::weakly_canonical(*job.recording).string() : "");
    last = &job;
  }
  return hash.hex();
}

void take_origin(scenario::ReadScenario& read, const fs::path& set_by) {
  read.origin.clear();
  for (const auto& [key, by] : files::read_json(set_by).entries()) read.origin[key] = by.text();
}

}  // namespace cli
