#include <fmt/ranges.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <numeric>
#include <set>

#include "tools/cli/jobs/jobs.h"

namespace cli {
namespace {

constexpr double kElementSeconds = 30;  // shorter elements are not worth the cost of starting them
constexpr int kSubmissions = 3, kRestarts = 10;
constexpr std::size_t kMostElements = 1000;          // limited by Slurm's default MaxArraySize, 1001
constexpr int kMostUnanswered = 60, kPatience = 10;  // ten minutes in total, polling less often

/// Returns the job in the output of `sbatch --parsable`, if any: a line "1000", or "1000;alpha" for another
/// cluster of a federation.
std::optional<std::string> job_in(const std::string& text) {
  for (const std::string& line : files::lines_of(text))
    if (files::parse_number<std::uint64_t>(line.substr(0, line.find(';')))) return line;
  return std::nullopt;
}

/// Returns the arguments that select a job: "-j 1000", or "-M alpha -j 1000".
std::string selected(const std::string& job, const char* by = "-j ") {
  const std::size_t end = std::min(job.find(';'), job.size());
  const std::string id = by + files::shell_word(job.substr(0, end));
  return end == job.size() ? id : fmt::format("-M {} {}", files::shell_word(job.substr(end + 1)), id);
}

/// Returns "1000", or "1000 of cluster alpha".
std::string named(const std::string& job) {
  const std::size_t end = std::min(job.find(';'), job.size());
  return job.substr(0, end) + (end == job.size() ? "" : " of cluster " + job.substr(end + 1));
}

/// The state of a job according to Slurm.
struct Seen {
  enum class Presence { queued, ended, unknown } presence = Presence::unknown;
  std::string waiting;  ///< states and reasons of elements that are not running: "PENDING (JobHeldUser)"
  std::string fault;    ///< error message of squeue
};

/// Asks squeue. It reports an invalid id if the job ended some minutes ago, but also if the job is on another
/// cluster. Only Slurm's accounting, if available, then shows that the job has ended.
Seen look_up(const std::string& job) {
  if (job.empty()) return {Seen::Presence::ended, "", ""};
  const ShellOutput shown = run_shell("squeue -h -o '%T %r' " + selected(job));
  const bool answered = shown.status == 0;
  const ShellOutput kept = answered ? shown : run_shell("sacct -n -X -P -o State " + selected(job));
  std::set<std::string> waiting;
  bool any = false, active = false;
  for (const std::string& line : files::lines_of(kept.status == 0 ? kept.text : "")) {
    if (line.empty() || line.starts_with("CLUSTER:")) continue;
    const std::string state = line.substr(0, line.find(' '));
    const bool runs = state == "RUNNING" || state == "COMPLETING";
    any = true;
    if (answered && !runs)
      waiting.insert(state == line ? line : fmt::format("{} ({})", state, line.substr(state.size() + 1)));
    active |=
        runs || state == "PENDING" || state == "REQUEUED" || state == "RESIZING" || state == "SUSPENDED";
  }
  if (answered ? any : active)
    return {Seen::Presence::queued, fmt::format("{}", fmt::join(waiting, ", ")), ""};
  if (answered || any) return {Seen::Presence::ended, "", ""};
  return {Seen::Presence::unknown, "", shown.errors.substr(0, shown.errors.find('\n'))};
}

/// True unless the job is known to have ended.
bool may_run(const std::string& job) { return look_up(job).presence != Seen::Presence::ended; }

/// Returns an environment variable, or "".
std::string setting(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

/// Returns the time between two queries of squeue.
useconds_t poll_us() {
  const std::string named = setting("GAITSLAM_SLURM_POLL_S");
  const auto seconds = files::parse_finite(named.empty() ? "1" : named);
  if (!seconds || *seconds <= 0 || *seconds > 300)
    throw UsageError("GAITSLAM_SLURM_POLL_S: is '{}', expected seconds, more than 0 and at most 300", named);
  return static_cast<useconds_t>(1e6 * *seconds);
}

std::string text_if_there(const fs::path& file) { return fs::exists(file) ? files::read_text(file) : ""; }

constexpr const char* kRecords =
    ".records";  // extension of an element's file with the records of its ended jobs

/// A job array and its folder in the spool, with the jobs, the id of the Slurm job, and the elements' files.
class Array {
 public:
  explicit Array(const fs::path& spool) : folder_(fs::absolute(spool) / "array") {}

  const fs::path& folder() const { return folder_; }
  std::string job() const { return text_if_there(folder_ / "job"); }
  std::vector<Job> jobs() const {
    return fs::exists(folder_ / "jobs") ? jobs_in(folder_ / "jobs") : std::vector<Job>();
  }

  /// Calls on_records for the elements that have written records since the last call.
  void read_records(const OnRecords& on_records) {
    for (const fs::path& file : files_with(kRecords)) {
      const std::uintmax_t bytes = fs::file_size(file);
      if (std::exchange(read_[file], bytes) != bytes) on_records(result::read_records(file));
    }
  }

  /// Submits the jobs as a new array.
  void submit(const std::vector<Job>& jobs, const Backend& backend) {
    const fs::path program = fs::read_symlink("/proc/self/exe");
    if (!fs::exists(program))
      throw UsageError("the program file was replaced while it was running; run the command again");
    const auto least = std::size_t(std::ceil(kElementSeconds / std::max(backend.seconds_each, 0.1)));
    const std::size_t each = std::max(jobs.front().batched ? 4 * kMostOfBatch : least,
                                      (jobs.size() + kMostElements - 1) / kMostElements);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    read_.clear();
    write_jobs(folder_ / "jobs", jobs);
    files::write_text(folder_ / "element.sh", fmt::format("#!/bin/sh\nexec {} element \"$1\" \"$2\"\n",
                                                          files::shell_word(program.string())));
    std::vector<std::size_t> elements((jobs.size() + each - 1) / each);
    std::iota(elements.begin(), elements.end(), std::size_t{0});
    const ShellOutput printed = run_shell(fmt::format(
        "sbatch --parsable --requeue --ntasks=1 --cpus-per-task=1 --job-name=gaitslam "
        "--array={}{} --output={} {} {} {}",
        fmt::join(elements, ","), backend.jobs > 0 ? fmt::format("%{}", backend.jobs) : "",
        files::shell_word((folder_ / "%a.txt").string()),
        files::shell_word((folder_ / "element.sh").string()), files::shell_word(folder_.string()), each));
    const std::optional<std::string> job = job_in(printed.text);
    if (printed.status != 0 || !job) {
      std::string why = printed.errors + printed.text;
      std::ranges::replace(why, '\n', ' ');
      if (why.empty())
        why = fmt::format("failed without a message (exit status {}), expected the id of a job",
                          WEXITSTATUS(printed.status));
      throw UsageError("sbatch: " + why);
    }
    files::write_atomically(folder_ / "job", *job);
    std::cerr
        << printed.errors
        << fmt::format(
               "slurm job {}: {} with up to {} each. After an interruption, rerun the command to continue "
               "with it.\n",
               named(*job), files::counted(elements.size(), "array element"), files::counted(each, "job"));
  }

  /// Returns each distinct text that elements printed.
  std::string complaints() const {
    std::set<std::string> all;
    for (const fs::path& file : files_with(".txt")) all.insert(files::read_text(file));
    return fmt::format("{}", fmt::join(all, ""));
  }

 private:
  std::vector<fs::path> files_with(const char* extension) const {
    std::vector<fs::path> all;
    std::error_code fault;
    for (const auto& entry : fs::directory_iterator(folder_, fault))
      if (entry.path().extension() == extension) all.push_back(entry.path());
    return all;
  }

  fs::path folder_;
  std::map<fs::path, std::uintmax_t> read_;  ///< sizes of the files read so far
};

/// Waits for records of the jobs while the array may still run, and prints the states of waiting elements
/// when they change. Throws UsageError if Slurm gives no answer for a long time.
void wait_for(Array& array, const std::vector<Job>& jobs, const ShowPart& show, const OnRecords& on_records) {
  const std::string job = array.job();
  const auto all = double(jobs.size());
  std::string waiting;
  for (int unanswered = 0;;) {
    const Seen seen = look_up(job);
    array.read_records(on_records);
    const bool ended = seen.presence == Seen::Presence::ended;
    OnInterrupt::add(ended ? ""
                           : fmt::format("slurm job {} still runs; to end it: scancel {}\n", named(job),
                                         selected(job, "")));
    if (ended || jobs.empty()) return;
    unanswered = seen.presence == Seen::Presence::unknown ? unanswered + 1 : 0;
    if (unanswered > kMostUnanswered)
      throw UsageError(
          "slurm job {}: its state is unknown: {}. Rerun the command to continue with it; if it has ended, "
          "first remove {}",
          named(job), seen.fault, (array.folder() / "job").string());
    if (unanswered == 0 && seen.waiting != waiting) {
      waiting = seen.waiting;
      std::cerr << fmt::format("slurm job {}: {}\n", named(job), waiting.empty() ? "RUNNING" : waiting);
    }
    show(1 - double(jobs.size()) / all);
    usleep(poll_us() * (unanswered > 0 ? kPatience : 1));
  }
}

}  // namespace

ShellOutput run_shell(const std::string& command) {
  const TemporaryFolder scratch;
  const std::string text = (scratch / "text").string(), errors = (scratch / "errors").string();
  std::FILE* const shell = ::popen(
      fmt::format("{} >{} 2>{}", command, files::shell_word(text), files::shell_word(errors)).c_str(), "w");
  const int status = shell ? ::pclose(shell) : -1;
  return {files::read_text(text), files::read_text(errors), status};
}

int run_element(ElementRequest& request) {
  const auto element = files::parse_number<std::size_t>(setting("SLURM_ARRAY_TASK_ID"));
  if (!element) throw UsageError("element: expected SLURM_ARRAY_TASK_ID");
  if (files::parse_number<int>(setting("SLURM_RESTART_COUNT")).value_or(0) > kRestarts)
    throw files::FileError("array element", fmt::format("was restarted more than {} times", kRestarts));
  std::vector<Job> jobs = jobs_in(request.folder / "jobs");
  const std::size_t first = std::min(*element * request.each, jobs.size());
  jobs = {jobs.begin() + std::ptrdiff_t(first),
          jobs.begin() + std::ptrdiff_t(std::min(first + request.each, jobs.size()))};
  const fs::path file = request.folder / fmt::format("{}{}", *element, kRecords);
  std::vector<JobRecord> records;  // at first the lines before a restart
  if (fs::exists(file)) records = result::read_records(file);
  std::erase_if(jobs,
                [&](const Job& job) { return std::ranges::count(records, job.key, &JobRecord::key) > 0; });
  if (jobs.empty()) return 0;
  const auto write = [&](const std::vector<JobRecord>& ended) {
    records.insert(records.end(), ended.begin(), ended.end());
    files::write_atomically(file, result::to_lines(records));
  };
  run_here(
      jobs, 1, [](double) {}, write);
  return 0;
}

void clear_spool(const fs::path& spool) {
  if (spool.empty()) return;
  const Array array(spool);
  if (may_run(array.job()))
    throw UsageError("{}: belongs to a Slurm job that may still run; wait for it, or end it: scancel {}",
                     array.folder().string(), selected(array.job(), ""));
  std::error_code fault;
  fs::remove_all(array.folder(), fault);
  fs::remove(spool, fault);  // only if it is empty
}

void run_on_slurm(std::vector<Job> jobs, const Backend& backend, const ShowPart& show,
                  const OnRecords& on_records) {
  Array array(backend.spool);
  std::set<std::string> recorded;
  std::optional<std::string> device_failure;
  const OnRecords take = [&](const std::vector<JobRecord>& records) {
    for (const JobRecord& record : records) {
      if (!recorded.insert(record.key).second) continue;
      if (exit_code_of(record) == kDeviceFailed) device_failure = record.cause;
      if (std::erase_if(jobs, [&](const Job& job) { return job.key == record.key; }) > 0)
        on_records({record});
    }
  };
  array.read_records(take);
  const auto is_other = [&](const Job& left) {
    return !recorded.contains(left.key) && std::ranges::count(jobs, left.key, &Job::key) == 0;
  };
  if (std::ranges::any_of(array.jobs(), is_other)) clear_spool(backend.spool);
  for (int submissions = 0;; ++submissions) {
    wait_for(array, jobs, show, take);
    if (jobs.empty() || submissions == kSubmissions) break;
    array.submit(jobs, backend);
  }
  const std::string complaint = "its array element ended before it ran: " + array.complaints();
  if (!jobs.empty() && jobs.front().batched) std::cerr << complaint;
  for (const Job& job : std::vector<Job>(jobs))
    if (!job.batched) on_records({{job.key, job.seed, "ended", complaint, {{"exit_code", 3}}}});
  std::error_code fault;
  fs::remove_all(array.folder(), fault);
  fs::remove(backend.spool, fault);
  if (device_failure) fail_by_device(*device_failure);
}

}  // namespace cli
