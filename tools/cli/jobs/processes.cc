#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>

#include "sim/files/json.h"
#include "sim/files/text.h"
#include "tools/cli/jobs/backend.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/terminal.h"

namespace cli {
namespace {

using files::FileLock;
constexpr useconds_t kChildPollUs = 10'000;
constexpr int kPollsForParts = 20;  // between two looks at the progress
constexpr std::string_view kTemporary = "gaitslam-XXXXXX";
constexpr const char* kLock = ".gaitslam-temporary";  // no folder of results has such a file

/// The file for the progress of the process, beside its log.
fs::path part_file(const fs::path& log) { return log.string() + ".part"; }

/// Starts this program with its standard error written to a file.
pid_t start(const CommandLine& line, const fs::path& log) {
  std::vector<std::string> words{"gaitslam"};
  words.insert(words.end(), line.words.begin(), line.words.end());
  words.insert(words.end(), {"--die-with-parent", std::to_string(getpid())});
  std::vector<char*> argv, environment;
  for (std::string& word : words) argv.push_back(word.data());
  std::string progress_file = fmt::format("{}={}", kProgressFile, part_file(log).string());
  environment.push_back(progress_file.data());
  for (char** variable = environ; *variable; ++variable) environment.push_back(*variable);
  argv.push_back(nullptr);
  environment.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t process = 0;
  const int fault = posix_spawn(&process, "/proc/self/exe", &files, nullptr, argv.data(), environment.data());
  posix_spawn_file_actions_destroy(&files);
  if (fault != 0) throw std::system_error(fault, std::generic_category(), "cannot start a process");
  return process;
}

Exited ended(int status, const fs::path& log) {
  const std::string text = files::read_text(log);
  if (WIFEXITED(status)) return {WEXITSTATUS(status), text};
  const int signal = WTERMSIG(status);
  return {3, text + fmt::format("killed by signal {} ({})\n", signal, strsignal(signal)), signal};
}

/// True for a TemporaryFolder of this user's ended process.
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

/// `jobs` processes at a time.
std::vector<Exited> run_processes(const CommandLines& command_lines, int jobs, const ShowPart& show,
                                  const OnEnded& on_ended) {
  const TemporaryFolder temporary;
  const auto log = [&](std::size_t i) { return temporary / std::to_string(i); };
  std::vector<Exited> all(command_lines.size());
  std::map<pid_t, std::size_t> running;
  std::vector<bool> has_ended(all.size());
  const auto part = [&](std::size_t i) { return has_ended[i] ? 1 : part_in(part_file(log(i))); };
  int polls = 0;
  bool can_write = true;  // else no further process is started
  for (std::size_t next = 0; can_write ? next < all.size() || !running.empty() : !running.empty();) {
    if (polls++ % kPollsForParts == 0) show(part_of_cost(command_lines, part));
    if (can_write && next < all.size() && running.size() < static_cast<std::size_t>(jobs)) {
      running[start(command_lines[next], log(next))] = next;
      ++next;
      continue;
    }
    int status = 0;
    const pid_t ended_one = waitpid(-1, &status, WNOHANG);
    const auto process = running.find(ended_one);
    if (ended_one == 0) usleep(kChildPollUs);
    if (process == running.end()) continue;
    all[process->second] = ended(status, log(process->second));
    has_ended[process->second] = true;
    can_write &= all[process->second].exit_code != kDeviceFailed;
    if (on_ended) on_ended(process->second);
    running.erase(process);
  }
  return all;
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  const char* const named = std::getenv("TMPDIR");
  const fs::path all = named ? named : "/tmp";
  std::error_code fault;
  if (!fs::is_directory(all, fault))
    throw UsageError("TMPDIR: {}: expected a folder for temporary files", all.string());
  for (const auto& entry : fs::directory_iterator(all, fault))
    if (is_abandoned(entry.path())) fs::remove_all(entry.path(), fault);
  std::string pattern = (all / kTemporary).string();
  if (mkdtemp(pattern.data()) == nullptr) files::fail_by_errno(pattern, "cannot be made");
  path_ = pattern;
  lock_ = FileLock::acquire(path_ / kLock, FileLock::How::exclusive);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void die_with(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) raise(SIGKILL);
}

double part_of_cost(const CommandLines& lines, const std::function<double(std::size_t)>& part) {
  double done = 0, all = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    done += lines[i].cost * part(i);
    all += lines[i].cost;
  }
  return done / all;
}

void require_usable(const Backend& backend, const std::string& folder) {
  if (!backend.slurm() || folder.find_first_of("\n\r") == folder.npos) return;
  throw UsageError("--out '{}': has a line break, which Slurm command lines cannot have",
                   folder.substr(0, folder.find_first_of("\n\r")));
}

void add_backend_options(CLI::App& command, Backend& backend) {
  command.add_option("--jobs", backend.jobs, "processes at a time (default 1); array elements on Slurm")
      ->check(CLI::Range(1, 100000));
  add_backend(command, backend.name);
}

void add_backend(CLI::App& command, std::string& name) {
  command.add_option("--backend", name, "processes on this machine, or a job array on the cluster")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
}

std::vector<Exited> run_all(const CommandLines& command_lines, const Backend& backend, const ShowPart& show,
                            const OnEnded& on_ended) {
  if (command_lines.empty()) return {};
  const std::vector<Exited> all =
      backend.slurm() ? run_on_slurm(command_lines, backend, show)
                      : run_processes(command_lines, std::max(backend.jobs, 1), show, on_ended);
  const auto failed = std::ranges::find(all, kDeviceFailed, &Exited::exit_code);
  if (failed == all.end()) return all;
  std::string_view why = failed->complaint;
  why = why.substr(0, why.find_last_not_of('\n') + 1);
  why = why.substr(why.rfind('\n') + 1);
  if (why.starts_with(kProgramPrefix)) why.remove_prefix(kProgramPrefix.size());
  throw files::DeviceError(fmt::format("{}; finished results are kept, rerun the command to resume", why));
}

FrozenScenarios::FrozenScenarios(const Backend& backend) {
  if (!backend.slurm()) temporary_.emplace();
  folder_ = temporary_ ? *temporary_ / "" : backend.spool;
  fs::create_directories(folder_);
}

FrozenScenarios::~FrozenScenarios() {
  if (temporary_ || std::uncaught_exceptions() > 0) return;  // a job that may still run reads them
  std::error_code ignored;
  for (const std::string& name : written_)
    for (const char* end : {".yaml", ".set_by.json"}) fs::remove(folder_ / (name + end), ignored);
  fs::remove(folder_, ignored);  // only if it is empty
}

std::vector<std::string> FrozenScenarios::words(const std::string& name, const scenario::ReadScenario& read) {
  const fs::path file = folder_ / (name + ".yaml"), set_by = folder_ / (name + ".set_by.json");
  if (written_.insert(name).second) {
    files::write_text(file, scenario::to_yaml(read.scenario));
    files::write_text(set_by, files::json_text(nlohmann::ordered_json(read.origin)));
  }
  return {file.string(), "--set-by", set_by.string()};
}

}  // namespace cli
