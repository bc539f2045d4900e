#include "tools/cli/jobs/processes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string_view>
#include <system_error>

#include "sim/files/text.h"
#include "tools/cli/jobs/progress.h"
#include "tools/cli/shared/usage_error.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
using sim::files::FileLock;
constexpr useconds_t kChildPollUs = 10'000;
constexpr int kPollsForParts = 20;  // between two looks at the progress
constexpr std::string_view kTemporary = "gaitslam-XXXXXX";
constexpr const char* kLock = ".gaitslam-temporary";  // no folder of results has such a file

/// The file for the progress of the process, beside its log.
fs::path part_file(const fs::path& log) { return log.string() + ".part"; }

/// Our environment, and the name of that file.
std::vector<std::string> environment_of(const fs::path& log) {
  std::vector<std::string> all{fmt::format("{}={}", kProgressFile, part_file(log).string())};
  for (char** variable = environ; *variable; ++variable) all.emplace_back(*variable);
  return all;
}

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

/// Starts this program with its standard error written to a file.
pid_t start(const CommandLine& line, const fs::path& log) {
  std::vector<std::string> words{"gaitslam"};
  words.insert(words.end(), line.words.begin(), line.words.end());
  words.insert(words.end(), {"--die-with-parent", std::to_string(getpid())});
  std::vector<std::string> variables = environment_of(log);
  const std::vector<char*> argv = pointers_to(words), environment = pointers_to(variables);
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

Ended ended(int status, const fs::path& log) {
  if (WIFEXITED(status)) return {WEXITSTATUS(status), sim::files::read_text(log)};
  const int signal = WTERMSIG(status);
  return {3,
          sim::files::read_text(log) + fmt::format("killed by signal {} ({})\n", signal, strsignal(signal))};
}

/// True for a TemporaryFolder of this user's ended process.
bool is_abandoned(const fs::path& folder) {
  std::error_code fault;
  const std::string name = folder.filename();
  if (!name.starts_with(kTemporary.substr(0, kTemporary.find('X'))) || name.size() != kTemporary.size() ||
      !fs::is_directory(fs::symlink_status(folder, fault)))
    return false;
  try {
    return FileLock::take(folder / kLock, FileLock::How::try_existing).has_value();
  } catch (const sim::files::FileError&) {
    return false;
  }
}

void remove_abandoned(const fs::path& all) {
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator(all, fault))
    if (is_abandoned(entry.path())) fs::remove_all(entry.path(), fault);
}

fs::path folder_for_temporary_files() {
  const char* const named = std::getenv("TMPDIR");
  const fs::path folder = named ? named : "/tmp";
  std::error_code fault;
  if (!fs::is_directory(folder, fault))
    throw UsageError(fmt::format("TMPDIR: {}: expected a folder for temporary files", folder.string()));
  return folder;
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  const fs::path all = folder_for_temporary_files();
  remove_abandoned(all);
  std::string pattern = (all / kTemporary).string();
  if (mkdtemp(pattern.data()) == nullptr)
    throw UsageError(fmt::format("{}: {}", pattern, std::strerror(errno)));
  path_ = pattern;
  lock_ = FileLock::take(path_ / kLock, FileLock::How::exclusive);
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

std::vector<Ended> run_processes(const CommandLines& command_lines, int jobs, const ShowPart& show,
                                 const OnEnded& on_ended) {
  const TemporaryFolder temporary;
  const auto log = [&](std::size_t i) { return temporary / std::to_string(i); };
  std::vector<Ended> all(command_lines.size());
  std::map<pid_t, std::size_t> running;
  std::vector<bool> has_ended(all.size());
  const auto part = [&](std::size_t i) { return has_ended[i] ? 1 : part_in(part_file(log(i))); };
  int polls = 0;
  for (std::size_t next = 0, done = 0; done < all.size();) {
    if (polls++ % kPollsForParts == 0) show(part_of_cost(command_lines, part));
    if (next < all.size() && running.size() < static_cast<std::size_t>(jobs)) {
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
    if (on_ended) on_ended(process->second);
    running.erase(process);
    ++done;
  }
  return all;
}

}  // namespace cli
