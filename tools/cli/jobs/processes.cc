#include "tools/cli/jobs/processes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <map>
#include <system_error>

#include "sim/files/text.h"
#include "tools/cli/usage_error.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
constexpr useconds_t kChildPollUs = 10'000;

/// Starts this program with its standard error written to a file.
pid_t start(const std::vector<std::string>& command_line, const fs::path& log) {
  std::vector<std::string> words{"gaitslam"};
  words.insert(words.end(), command_line.begin(), command_line.end());
  words.insert(words.end(), {"--die-with-parent", std::to_string(getpid())});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t process = 0;
  const int fault = posix_spawn(&process, "/proc/self/exe", &files, nullptr, argv.data(), environ);
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

}  // namespace

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (fs::temp_directory_path() / "gaitslam-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr)
    throw UsageError(fmt::format("{}: {}", pattern, std::strerror(errno)));
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void die_with(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) raise(SIGKILL);
}

std::vector<Ended> run_processes(const CommandLines& command_lines, int jobs, const ShowPart& show) {
  const TemporaryFolder temporary;
  const auto log = [&](std::size_t i) { return temporary / std::to_string(i); };
  std::vector<Ended> all(command_lines.size());
  std::map<pid_t, std::size_t> running;
  for (std::size_t next = 0, done = 0; done < all.size();) {
    show(static_cast<double>(done) / static_cast<double>(all.size()));
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
    running.erase(process);
    ++done;
  }
  return all;
}

}  // namespace cli
