#include "tools/cli/jobs/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace cli {
namespace {

// Names the package of programs that only some commands need and that are not installed by default.
std::string where_from(const std::string& program) {
  if (program == "rsvg-convert") return "; Debian's package librsvg2-bin has it";
  if (program == "ffmpeg") return "; Debian's package ffmpeg has it";
  return "";
}

// Starts a program with `input` as its standard input and `errors` as its standard error. Negative: no input,
// and our standard error.
pid_t start(const std::vector<std::string>& argv, int input, int errors) {
  std::vector<char*> arguments;
  for (const std::string& argument : argv) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  if (input < 0)
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  else
    posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  if (errors >= 0) posix_spawn_file_actions_adddup2(&files, errors, STDERR_FILENO);
  pid_t process = 0;
  const int fault = posix_spawnp(&process, arguments[0], &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (fault != 0)
    throw std::runtime_error(
        fmt::format("{} cannot be run: {}{}", argv[0], std::strerror(fault), where_from(argv[0])));
  return process;
}

bool ends_well(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// The first line of a file, after ": "; empty for an empty file.
std::string first_line(int file) {
  std::array<char, 1000> bytes{};
  const ssize_t n = ::pread(file, bytes.data(), bytes.size(), 0);
  const std::string_view text(bytes.data(), n < 0 ? 0 : static_cast<std::size_t>(n));
  return text.empty() ? "" : fmt::format(": {}", text.substr(0, text.find('\n')));
}

}  // namespace

void run_child(const std::vector<std::string>& argv) {
  if (!ends_well(start(argv, -1, -1))) throw std::runtime_error(fmt::format("{} failed", argv[0]));
}

FedChild::FedChild(const std::vector<std::string>& argv) : name_(argv[0]) {
  ::signal(SIGPIPE, SIG_IGN);  // write() reports a child that ended early
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    throw std::runtime_error(fmt::format("no pipe to {}: {}", name_, std::strerror(errno)));
  input_ = ends[1];
  errors_ = ::memfd_create("errors", MFD_CLOEXEC);
  try {
    process_ = start(argv, ends[0], errors_);
  } catch (...) {
    ::close(ends[0]), ::close(ends[1]), ::close(errors_);
    throw;
  }
  ::close(ends[0]);
}

FedChild::~FedChild() {
  if (input_ >= 0) {
    ::close(input_);
    ends_well(process_);
  }
  ::close(errors_);
}

void FedChild::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(input_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const std::string fault = std::strerror(errno);
      finish();
      throw std::runtime_error(fmt::format("{} ended early: {}", name_, fault));
    }
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

void FedChild::finish() {
  ::close(input_);
  input_ = -1;
  if (!ends_well(process_)) throw std::runtime_error(fmt::format("{} failed{}", name_, first_line(errors_)));
}

}  // namespace cli
