#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <system_error>

#include "sim/files/json.h"
#include "tools/cli/jobs/jobs.h"
#include "tools/cli/jobs/progress.h"

namespace cli {

namespace {

constexpr useconds_t kChildPollUs = 10'000;
constexpr int kPollsForParts = 20;  // polls between two checks of progress

/// A process and its jobs.
struct Process {
  std::vector<Job> jobs;
  std::string files;  ///< path of its files without extension

  fs::path file(const char* extension) const { return files + extension; }
};

/// Returns the command line of the process and writes its files. The parent's id is the id of this process.
std::vector<std::string> command_line(const Process& process) {
  const Job& job = process.jobs.front();
  std::vector<std::string> words{"gaitslam"};
  words.insert(words.end(), job.words.begin(), job.words.end());
  if (job.batched) {
    write_jobs(process.file(".jobs"), process.jobs);
    words.insert(words.end(), {process.file(".jobs"), process.file(".records")});
  } else if (!job.scenario.empty()) {
    files::write_text(process.file(".yaml"), job.scenario);
    files::write_text(process.file(".json"), files::json_text(nlohmann::ordered_json(job.origin)));
    std::ranges::replace(words, kScenarioFile, process.file(".yaml").string());
    words.insert(words.end(), {"--set-by", process.file(".json")});
  }
  words.insert(words.end(), {"--die-with-parent", std::to_string(getpid())});
  return words;
}

pid_t spawn(const Process& process) {
  std::vector<std::string> words = command_line(process);
  std::vector<char*> argv, environment;
  for (std::string& word : words) argv.push_back(word.data());
  std::string progress_file = fmt::format("{}={}", kProgressFile, process.file(".part").string());
  environment.push_back(progress_file.data());
  for (char** variable = environ; *variable; ++variable) environment.push_back(*variable);
  argv.push_back(nullptr);
  environment.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  constexpr int kWrite = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, process.file(".out").c_str(), kWrite, 0600);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, process.file(".err").c_str(), kWrite, 0600);
  pid_t id = 0;
  const fs::path& other = process.jobs.front().program;
  const int fault = posix_spawn(&id, other.empty() ? "/proc/self/exe" : other.c_str(), &files, nullptr,
                                argv.data(), environment.data());
  posix_spawn_file_actions_destroy(&files);
  if (fault != 0) throw std::system_error(fault, std::generic_category(), "cannot start a process");
  return id;
}

/// Splits the jobs into one list per process: as few lists as keep all processes equally busy, because each
/// process that runs batched jobs must decode its recording.
std::deque<std::vector<Job>> batches(const std::vector<Job>& jobs, int processes) {
  const auto up = [](std::size_t a, std::size_t b) { return (a + b - 1) / b; };
  const auto at_a_time = std::size_t(processes);
  const std::size_t most = up(jobs.size(), at_a_time * up(jobs.size(), at_a_time * kMostOfBatch));
  std::deque<std::vector<Job>> all;
  for (const Job& job : jobs) {
    if (all.empty() || !job.batched || all.back().size() == most) all.emplace_back();
    all.back().push_back(job);
  }
  return all;
}

class Launcher {
 public:
  Launcher(const std::vector<Job>& jobs, int processes, const OnRecords& on_records)
      : waiting_(batches(jobs, processes)), most_(std::size_t(processes)), on_records_(on_records) {
    for (const Job& job : jobs) cost_ += job.cost;
  }

  void run(const ShowPart& show) {
    for (int polls = 0; !waiting_.empty() || !running_.empty(); ++polls) {
      while (!waiting_.empty() && running_.size() < most_) start();
      int status = 0;
      if (const auto ended = running_.extract(waitpid(-1, &status, WNOHANG)))
        end(ended.mapped(), status);
      else
        usleep(kChildPollUs);
      if (polls % kPollsForParts == 0) show(part());
    }
    if (device_failure_) fail_by_device(*device_failure_);
  }

 private:
  void start() {
    Process process{std::move(waiting_.front()), (temporary_ / std::to_string(started_++)).string()};
    waiting_.pop_front();
    running_.emplace(spawn(process), std::move(process));
  }

  void end(const Process& process, int status) {
    const std::string killed = WIFSIGNALED(status) ? fmt::format("killed by signal {} ({})", WTERMSIG(status),
                                                                 strsignal(WTERMSIG(status)))
                                                   : "";
    const std::string complaint =
        files::sanitize(files::read_text(process.file(".err"))) + (killed.empty() ? "" : killed + "\n");
    const int exit_code = killed.empty() ? WEXITSTATUS(status) : 3;
    if (exit_code == kDeviceFailed) waiting_.clear(), device_failure_ = complaint;
    const Job& first = process.jobs.front();
    std::vector<JobRecord> records;
    if (!first.batched)
      records = {{first.key, first.seed, "ended", complaint, {{"exit_code", exit_code}}}};
    else if (fs::exists(process.file(".records")))
      records = result::read_records(process.file(".records"));
    else if (process.jobs.size() > 1 && !device_failure_)
      for (const Job& job : process.jobs) waiting_.push_back({job});
    else if (!killed.empty())
      records = {{first.key, first.seed, "crashed", killed, {}}};
    else if (!device_failure_ && complaints_.insert(complaint).second)
      std::cerr << complaint;
    if (process.jobs.size() == 1 || !records.empty()) done_ += cost_of(process);
    on_records_(records);
  }

  static double cost_of(const Process& process) {
    double cost = 0;
    for (const Job& job : process.jobs) cost += job.cost;
    return cost;
  }

  double part() const {
    double done = done_;
    for (const auto& [id, process] : running_) done += cost_of(process) * part_in(process.file(".part"));
    return done / cost_;
  }

  const TemporaryFolder temporary_;
  std::deque<std::vector<Job>> waiting_;
  std::map<pid_t, Process> running_;
  std::set<std::string> complaints_;
  std::optional<std::string> device_failure_;  ///< if a process reports one, no more processes are started
  std::size_t most_;
  int started_ = 0;
  double cost_ = 0, done_ = 0;
  const OnRecords& on_records_;
};

/// Returns a new name in the folder for temporary files, and removes files left there by killed processes.
fs::path temporary_name() {
  const char* const named = std::getenv("TMPDIR");
  const fs::path all = named ? named : "/tmp";
  std::error_code fault;
  if (!fs::is_directory(all, fault))
    throw UsageError("TMPDIR: {}: is not a folder, expected one for temporary files", all.string());
  files::remove_leftovers(all);
  std::random_device random;
  return all / fmt::format("gaitslam-{:08x}{:08x}", random(), random());
}

}  // namespace

TemporaryFolder::TemporaryFolder() : folder_(temporary_name()) {}

void die_with(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) raise(SIGKILL);
}

void fail_by_device(std::string_view complaint) {
  complaint = complaint.substr(0, complaint.find_last_not_of('\n') + 1);
  complaint = complaint.substr(complaint.rfind('\n') + 1);
  if (complaint.starts_with(kProgramPrefix)) complaint.remove_prefix(kProgramPrefix.size());
  if (complaint.empty()) complaint = "a disk is full, probably that of TMPDIR, or a device failed";
  throw files::DeviceError(
      fmt::format("{}; finished results are kept, rerun the command to resume", complaint));
}

void write_jobs(const fs::path& file, const std::vector<Job>& jobs) {
  std::string text;
  for (const Job& job : jobs)
    text += files::json_text({{"key", job.key},
                              {"seed", job.seed},
                              {"words", job.words},
                              {"batched", job.batched},
                              {"scenario", job.scenario},
                              {"origin", job.origin},
                              {"recording", job.recording.string()},
                              {"cost", job.cost},
                              {"program", job.program.string()}}) +
            '\n';
  files::write_atomically(file, text);
}

std::vector<Job> jobs_in(const fs::path& file) {
  std::vector<Job> jobs;
  for (const std::string& line : files::lines_of(files::read_text(file))) {
    const files::Json job(file, line);
    jobs.push_back({job.at("key").text(), job.at("seed").whole(), job.at("words").value(),
                    job.at("batched").flag(), job.at("scenario").value(), job.at("origin").value(),
                    job.at("recording").value().get<std::string>(), job.at("cost").number(),
                    job.at("program").value().get<std::string>()});
  }
  return jobs;
}

int exit_code_of(const JobRecord& record) { return int(record.value("exit_code").value_or(0)); }

void run_here(const std::vector<Job>& jobs, int processes, const ShowPart& show,
              const OnRecords& on_records) {
  Launcher(jobs, processes, on_records).run(show);
}

void run_jobs(const std::vector<Job>& jobs, const Backend& backend, const std::string& title,
              const OnRecords& on_records) {
  if (jobs.empty()) return;
  ProgressLine progress(title);
  const ShowPart show = [&](double part) { progress.show(part); };
  if (backend.slurm()) return run_on_slurm(jobs, backend, show, on_records);
  clear_spool(backend.spool);
  run_here(jobs, std::max(backend.jobs, 1), show, on_records);
}

}  // namespace cli
