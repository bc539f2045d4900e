#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "sim/files/json.h"
#include "tools/cli/jobs/jobs.h"
#include "tools/cli/jobs/progress.h"

namespace cli {

namespace {

using files::FileLock;
constexpr useconds_t kChildPollUs = 10'000;
constexpr int kPollsForParts = 20;  // polls between two checks of progress and records
constexpr std::string_view kTemporary = "gaitslam-XXXXXX";
constexpr const char* kLock = ".gaitslam-temporary";  // no results folder contains such a file

/// Distinguishes a folder from its replacement: device and inode, or nullopt if it does not exist.
using Identity = std::optional<std::pair<dev_t, ino_t>>;

Identity identity_of(const fs::path& folder) {
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0) return std::nullopt;
  return std::pair(status.st_dev, status.st_ino);
}

/// A process and its jobs that have no record yet; they run one after another.
struct Process {
  std::vector<Job> jobs;
  std::size_t begun = 0;  ///< number of its jobs at the start
  std::string files;      ///< path of its files without extension
  Identity before;        ///< its job's folder at the start
  std::size_t read = 0;   ///< bytes of its output read so far
  std::string running{};  ///< key of the batched job that it last announced

  fs::path file(const char* extension) const { return files + extension; }
};

/// Returns the command line of the process and writes its files. The parent's id is that of this process.
std::vector<std::string> command_line(const Process& process) {
  const Job& job = process.jobs.front();
  std::vector<std::string> words{"gaitslam"};
  words.insert(words.end(), job.words.begin(), job.words.end());
  if (job.batched) {
    write_jobs(process.file(".jobs"), process.jobs);
    words.push_back(process.file(".jobs"));
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
  const int fault = posix_spawn(&id, "/proc/self/exe", &files, nullptr, argv.data(), environment.data());
  posix_spawn_file_actions_destroy(&files);
  if (fault != 0) throw std::system_error(fault, std::generic_category(), "cannot start a process");
  return id;
}

/// Splits the jobs into one list per process: as few lists as keep all processes equally busy, because each
/// process that runs batched jobs must decode its recording.
std::deque<std::vector<Job>> batches(const std::vector<Job>& jobs, int processes) {
  const auto up = [](std::size_t a, std::size_t b) { return (a + b - 1) / b; };
  const auto at_a_time = static_cast<std::size_t>(processes);
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
  Launcher(const std::vector<Job>& jobs, int processes, const OnRecord& on_record)
      : waiting_(batches(jobs, processes)),
        most_(static_cast<std::size_t>(processes)),
        on_record_(on_record) {
    for (const Job& job : jobs) cost_ += job.cost;
  }

  void run(const ShowPart& show) {
    for (int polls = 0; !waiting_.empty() || !running_.empty(); ++polls) {
      if (polls % kPollsForParts == 0) {
        for (auto& [id, process] : running_) read_records(process);
        show(part());
      }
      if (!waiting_.empty() && running_.size() < most_) {
        start();
        continue;
      }
      int status = 0;
      const auto process = running_.find(waitpid(-1, &status, WNOHANG));
      if (process == running_.end()) {
        usleep(kChildPollUs);
        continue;
      }
      end(process->second, status);
      running_.erase(process);
    }
    if (device_failure_) fail_by_device(*device_failure_);
  }

 private:
  void start() {
    Process process{std::move(waiting_.front()), 0, (temporary_ / std::to_string(started_++)).string(), {}};
    waiting_.pop_front();
    process.begun = process.jobs.size();
    process.before = identity_of(process.jobs.front().folder);
    running_.emplace(spawn(process), std::move(process));
  }

  void add(Process& process, const JobRecord& record) {
    const auto job = std::ranges::find(process.jobs, record.key, &Job::key);
    if (job == process.jobs.end()) return;
    done_ += job->cost;
    process.jobs.erase(job);
    on_record_(record);
  }

  /// Processes the complete lines that the process has printed since the last call.
  void read_records(Process& process) {
    if (process.jobs.empty() || !process.jobs.front().batched) return;
    const std::string text = files::read_text(process.file(".out")),
                      all = text.substr(0, text.rfind('\n') + 1);
    const std::size_t begin = std::min(std::exchange(process.read, all.size()), all.size());
    for (const std::string& line : files::lines_of(std::string_view(all).substr(begin)))
      if (line.starts_with(kBegin))
        process.running = line.substr(kBegin.size());
      else if (const auto record = result::from_line(line))
        add(process, *record);
  }

  /// Handles the end of a process; jobs that it has not reached run in a new one if it has finished any.
  void end(Process& process, int status) {
    read_records(process);
    const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    const std::string killed =
        signal ? fmt::format("killed by signal {} ({})", signal, strsignal(signal)) : "";
    const std::string complaint =
        files::sanitize(files::read_text(process.file(".err"))) + (signal ? killed + "\n" : "");
    const bool device_failed = WIFEXITED(status) && WEXITSTATUS(status) == kDeviceFailed;
    if (device_failed) waiting_.clear(), device_failure_ = complaint;
    if (process.jobs.empty()) return;
    const Job job = process.jobs.front();
    if (!job.batched) {
      const Identity now = identity_of(job.folder);
      const double code = signal ? 3 : WEXITSTATUS(status);
      return add(process, {job.key,
                           job.seed,
                           now && now != process.before ? kFinished : kFailed,
                           complaint,
                           {{"exit_code", code}}});
    }
    const auto running = std::ranges::find(process.jobs, process.running, &Job::key);
    if (signal && running != process.jobs.end())
      add(process, {running->key, running->seed, "crashed", killed, {}});
    if (device_failed) return;
    if (process.jobs.size() < process.begun && !process.jobs.empty())
      waiting_.push_front(process.jobs);
    else if (!process.jobs.empty() && complaints_.insert(complaint).second)
      std::cerr << complaint;
  }

  double part() const {
    double done = done_;
    for (const auto& [id, process] : running_)
      if (!process.jobs.empty() && !process.jobs.front().batched)
        done += process.jobs.front().cost * part_in(process.file(".part"));
    return done / cost_;
  }

  const TemporaryFolder temporary_;
  std::deque<std::vector<Job>> waiting_;
  std::map<pid_t, Process> running_;
  std::set<std::string> complaints_;
  std::optional<std::string> device_failure_;  ///< if a process reports one, no further ones are started
  std::size_t most_;
  int started_ = 0;
  double cost_ = 0, done_ = 0;
  const OnRecord& on_record_;
};

/// True for a TemporaryFolder left by an ended process of this user.
bool is_abandoned(const fs::path& folder) {
  std::error_code fault;
  const std::string name = folder.filename();
  if (!name.starts_with(kTemporary.substr(0, kTemporary.find('X'))) || name.size() != kTemporary.size() ||
      !fs::is_directory(fs::symlink_status(folder, fault)))
    return false;
  try {
    return FileLock::acquire(folder / kLock, FileLock::How::try_existing).has_value();
  } catch (const files::FileError&) {
    return false;
  }
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  const char* const named = std::getenv("TMPDIR");
  const fs::path all = named ? named : "/tmp";
  std::error_code fault;
  if (!fs::is_directory(all, fault))
    throw UsageError("TMPDIR: {}: is not a folder, expected one for temporary files", all.string());
  for (const auto& entry : fs::directory_iterator(all, fault))
    if (is_abandoned(entry.path())) fs::remove_all(entry.path(), fault);
  // The folder is locked before it gets its name; otherwise, other processes would remove it as abandoned.
  std::string unnamed = (all / fmt::format(".{}", kTemporary)).string();
  if (mkdtemp(unnamed.data()) == nullptr) files::fail_by_errno(unnamed, "cannot be made");
  lock_ = FileLock::acquire(fs::path(unnamed) / kLock, FileLock::How::exclusive);
  path_ = all / fs::path(unnamed).filename().string().substr(1);
  fs::rename(unnamed, path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void die_with(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) raise(SIGKILL);
}

void fail_by_device(std::string_view complaint) {
  complaint = complaint.substr(0, complaint.find_last_not_of('\n') + 1);
  complaint = complaint.substr(complaint.rfind('\n') + 1);
  if (complaint.starts_with(kProgramPrefix)) complaint.remove_prefix(kProgramPrefix.size());
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
                              {"folder", job.folder.string()},
                              {"cost", job.cost}}) +
            '\n';
  files::write_atomically(file, text);
}

std::vector<Job> jobs_in(const fs::path& file) {
  std::vector<Job> jobs;
  for (const std::string& line : files::lines_of(files::read_text(file))) {
    const files::Json job(file, line);
    jobs.push_back({job.at("key").text(), job.at("seed").whole(), job.at("words").value(),
                    job.at("batched").flag(), job.at("scenario").value(), job.at("origin").value(),
                    job.at("folder").value().get<std::string>(), job.at("cost").number()});
  }
  return jobs;
}

int exit_code_of(const JobRecord& record) { return static_cast<int>(record.value("exit_code").value_or(0)); }

void run_here(const std::vector<Job>& jobs, int processes, const ShowPart& show, const OnRecord& on_record) {
  Launcher(jobs, processes, on_record).run(show);
}

void run_jobs(const std::vector<Job>& jobs, const Backend& backend, const std::string& title,
              const OnRecord& on_record) {
  if (jobs.empty()) return;
  ProgressLine progress(title);
  const ShowPart show = [&](double part) { progress.show(part); };
  if (backend.slurm()) return run_on_slurm(jobs, backend, show, on_record);
  clear_spool(backend.spool);
  run_here(jobs, std::max(backend.jobs, 1), show, on_record);
}

}  // namespace cli
