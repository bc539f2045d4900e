#include "sim/estimators/child_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <deque>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "sim/estimators/estimator.h"

namespace sim::estimators {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostLog = 1 << 20;  // bytes of the log
constexpr std::size_t kLastLines = 5, kLongestLine = 200;
constexpr int kBuffer = 1 << 20;  // an observation fits, so that sending does not wait
constexpr auto kToEnd = std::chrono::seconds(1);

/// A pipe or socket pair that child programs do not inherit.
struct Ends {
  std::array<int, 2> file{-1, -1};
  ~Ends() {
    for (const int each : file)
      if (each >= 0) ::close(each);
  }
  int release(std::size_t end) { return std::exchange(file[end], -1); }
};

void require(bool made, const char* what) {
  if (!made) throw std::invalid_argument(fmt::format("estimator: {}: {}", what, std::strerror(errno)));
}

void open_pipe(Ends& ends) { require(::pipe2(ends.file.data(), O_CLOEXEC) == 0, "no pipe to the program"); }

// A socket: writing to a closed one is an error, not a signal.
void open_input(Ends& ends) {
  require(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.file.data()) == 0,
          "no socket to the program");
  ::setsockopt(ends.file[0], SOL_SOCKET, SO_SNDBUF, &kBuffer, sizeof kBuffer);
}

// Waits for the end of the parent, then kills its group. After fork, only async-signal-safe calls.
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

// After fork, only async-signal-safe calls.
[[noreturn]] void become(char* const* words, const std::array<int, 3>& standard, int report, pid_t parent,
                         const ProcessGuard& guard) {
  ::setpgid(0, 0);
  guard.watch(::getpid());  // first: the parent may end at any moment
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);  // it ended before prctl()
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD})
    ::signal(signal_number, SIG_DFL);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  for (int file = 0; file < 3; ++file) ::dup2(standard[static_cast<std::size_t>(file)], file);
  ::execvp(words[0], words);
  const int why = errno;
  [[maybe_unused]] const ssize_t written = ::write(report, &why, sizeof why);
  ::_exit(127);
}

std::string ended_text(int status) {
  if (WIFSIGNALED(status))
    return fmt::format("it was killed by signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  return fmt::format("it ended with exit code {}", WEXITSTATUS(status));
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
  errno = why;
  require(false, "no process for the program");
}

void ProcessGuard::watch(pid_t group) const {
  [[maybe_unused]] const ssize_t written = ::write(alive_, &group, sizeof group);
}

void ProcessGuard::release() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) continue;
  }
  process_ = -1;
  if (alive_ >= 0) ::close(std::exchange(alive_, -1));
}

ChildProgram::ChildProgram(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  Ends in, out, error, report;
  open_input(in), open_pipe(out), open_pipe(error), open_pipe(report);
  const pid_t parent = ::getpid();
  process_ = ::fork();
  require(process_ >= 0, "no process for the program");
  if (process_ == 0)
    become(arguments.data(), {in.file[1], out.file[1], error.file[1]}, report.file[1], parent, guard_);
  ::setpgid(process_, process_);
  ::close(report.release(1));
  int why = 0;
  ssize_t failed = 0;
  while ((failed = ::read(report.file[0], &why, sizeof why)) < 0 && errno == EINTR) continue;
  in_ = in.release(0), out_ = out.release(0), error_ = error.release(0);
  for (const int file : {in_, out_, error_}) ::fcntl(file, F_SETFL, O_NONBLOCK);
  if (failed <= 0) return;
  wait_until_ended(Clock::now() + kToEnd);
  for (const int file : {in_, out_, error_}) ::close(file);
  const bool has_arguments = words.size() == 1 && words[0].find(' ') != std::string::npos;
  throw std::invalid_argument(
      fmt::format("estimator: the program {} cannot be started: {}{}", words[0], std::strerror(why),
                  has_arguments ? "; its arguments are words of a list, as in [./my_slam, --stdio]" : ""));
}

ChildProgram::~ChildProgram() {
  kill();
  for (const int file : {in_, out_, error_})
    if (file >= 0) ::close(file);
}

void ChildProgram::send(std::string_view bytes, Deadline deadline) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(in_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent >= 0)
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    else if (errno == EAGAIN || errno == EWOULDBLOCK)
      wait_for(in_, POLLOUT, deadline);
    else if (errno != EINTR)
      fail_ended();
  }
}

std::string ChildProgram::receive(std::size_t bytes, Deadline deadline) {
  std::string received(bytes, '\0');
  for (std::size_t at = 0; at < bytes;) {
    const ssize_t got = ::read(out_, received.data() + at, bytes - at);
    if (got > 0)
      at += static_cast<std::size_t>(got);
    else if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK))
      wait_for(out_, POLLIN, deadline);
    else if (got == 0 || errno != EINTR)
      fail_ended();
  }
  return received;
}

// Reads its standard error meanwhile, so that the program does not block on it.
void ChildProgram::wait_for(int file, short events, Deadline deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
  if (left.count() <= 0) {
    kill();
    read_log();
    throw EstimatorFailed("no answer within its time limit");
  }
  std::array<pollfd, 2> files{pollfd{file, events, 0}, pollfd{error_, POLLIN, 0}};
  ::poll(files.data(), files.size(), static_cast<int>(std::min<long long>(left.count(), 1000)));
  if (files[1].revents != 0) read_log();
}

void ChildProgram::read_log() {
  std::array<char, 1 << 14> buffer;
  ssize_t got = 0;
  while (error_ >= 0 && (got = ::read(error_, buffer.data(), buffer.size())) != 0) {
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return;
    log_.append(buffer.data(), static_cast<std::size_t>(got));
    if (log_.size() <= 2 * kMostLog) continue;
    log_lost_ += log_.size() - kMostLog;
    log_.erase(0, log_.size() - kMostLog);
  }
  if (error_ >= 0) ::close(error_);
  error_ = -1;
}

// Returns whether it has ended; options: WNOHANG, or 0 to wait.
bool ChildProgram::reap(int options) {
  rusage used{};
  if (ended_ || ::wait4(process_, &status_, options, &used) != process_) return ended_;
  const auto ms = [](const timeval& time) {
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_usec);
  };
  whole_cpu_ms_ = ms(used.ru_utime) + ms(used.ru_stime);
  return ended_ = true;
}

bool ChildProgram::has_ended() { return reap(WNOHANG); }

void ChildProgram::wait_until_ended(Deadline deadline) {
  while (!has_ended() && Clock::now() < deadline) {
    read_log();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  read_log();
}

void ChildProgram::fail_ended() {
  wait_until_ended(Clock::now() + kToEnd);
  const bool ended = has_ended();
  kill();
  throw EstimatorFailed(ended ? ended_text(status_) : "it closed its standard input or output");
}

// Kills its whole group.
void ChildProgram::kill() {
  if (killed_) return;
  killed_ = true;
  ::kill(-process_, SIGKILL);
  guard_.release();
  while (!reap(0) && errno == EINTR) continue;
  ended_ = true;
}

void ChildProgram::run(Deadline deadline) {
  end(deadline);
  if (WIFSIGNALED(status_) && WTERMSIG(status_) == SIGKILL && Clock::now() >= deadline)
    throw EstimatorFailed("it did not exit within its time limit");
  if (!WIFEXITED(status_) || WEXITSTATUS(status_) != 0) throw EstimatorFailed(ended_text(status_));
}

void ChildProgram::end(Deadline deadline) {
  if (in_ >= 0) ::close(std::exchange(in_, -1));
  wait_until_ended(deadline);
  kill();
  read_log();
}

std::string ChildProgram::log() const {
  if (log_.size() <= kMostLog && log_lost_ == 0) return log_;
  const std::size_t kept = std::min(log_.size(), kMostLog);
  return fmt::format("(the first {} bytes are omitted)\n", log_lost_ + log_.size() - kept) +
         log_.substr(log_.size() - kept);
}

std::string ChildProgram::last_lines() const {
  std::istringstream in(log_);
  std::deque<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) lines.push_back(printable(std::string_view(line).substr(0, kLongestLine)));
    if (lines.size() > kLastLines) lines.pop_front();
  }
  return fmt::format("{}", fmt::join(lines, " | "));
}

double ChildProgram::cpu_ms() const {
  if (ended_) return whole_cpu_ms_;
  clockid_t clock{};
  timespec used{};
  if (::clock_getcpuclockid(process_, &clock) != 0 || ::clock_gettime(clock, &used) != 0) return 0;
  return 1e3 * static_cast<double>(used.tv_sec) + 1e-6 * static_cast<double>(used.tv_nsec);
}

}  // namespace sim::estimators
