#include "sim/estimators/process_guard.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace sim::estimators {
namespace {

// In the new process, where only functions may be called that a signal handler may call. It keeps no file of
// the other process open, and no signal that ends that one ends it.
[[noreturn]] void guard(int alive) {
  sigset_t all;
  ::sigfillset(&all);
  ::sigprocmask(SIG_SETMASK, &all, nullptr);
  ::setpgid(0, 0);
  ::dup2(alive, 0);
  ::close_range(1, ~0U, 0);
  pid_t group = 0;
  const bool watches = ::read(0, &group, sizeof group) == sizeof group && group > 1;
  char none = 0;
  while (watches && ::read(0, &none, 1) < 0 && errno == EINTR) continue;
  if (watches) ::kill(-group, SIGKILL);
  ::_exit(0);
}

}  // namespace

ProcessGuard::ProcessGuard() {
  std::array<int, 2> ends{};
  const bool piped = ::pipe2(ends.data(), O_CLOEXEC) == 0;
  if (piped) process_ = ::fork();
  if (process_ == 0) guard(ends[0]);
  const int why = errno;
  if (piped) ::close(ends[0]);
  alive_ = piped ? ends[1] : -1;
  if (process_ > 0) return;
  release();
  throw std::invalid_argument(fmt::format("estimator: no process for the program: {}", std::strerror(why)));
}

void ProcessGuard::watch(pid_t group) const {
  [[maybe_unused]] const ssize_t told = ::write(alive_, &group, sizeof group);
}

void ProcessGuard::release() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) continue;
  }
  process_ = -1;
  if (alive_ >= 0) ::close(std::exchange(alive_, -1));
}

}  // namespace sim::estimators
