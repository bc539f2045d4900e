#include "sim/programs/child_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/landlock.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <sstream>
#include <thread>
#include <utility>

namespace sim::programs {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostLog = 1 << 20;  // bytes of the log
constexpr std::size_t kLastLines = 5, kLongestLine = 200;
constexpr int kBuffer = 1 << 20;  // large enough for an observation, so that sending does not wait
constexpr double kToEnd_s = 1;

/// A pipe or socket pair that child programs do not inherit.
struct Ends {
  std::array<int, 2> file{-1, -1};
  ~Ends() {
    for (const int each : file)
      if (each >= 0) ::close(each);
  }
  int release(std::size_t end) { return std::exchange(file[end], -1); }
};

/// Returns Landlock's rules that allow changes of files only below a folder and of devices; -1 if there is no
/// folder, or if the kernel does not support them.
int rules_of(const std::filesystem::path& writable) {
  constexpr std::uint64_t kReading =
      LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
  const landlock_ruleset_attr changes{.handled_access_fs = (2 * LANDLOCK_ACCESS_FS_REFER - 1) & ~kReading};
  if (writable.empty()) return -1;
  const int rules = int(::syscall(SYS_landlock_create_ruleset, &changes, sizeof changes, 0));
  for (const char* const path : {writable.c_str(), "/dev"}) {
    const landlock_path_beneath_attr below{changes.handled_access_fs, ::open(path, O_PATH | O_CLOEXEC)};
    ::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &below, 0);
    ::close(below.parent_fd);
  }
  return rules;
}

// After fork, only async-signal-safe calls are allowed. rules: see rules_of.
[[noreturn]] void become(char* const* words, const std::array<int, 3>& standard, int report, pid_t parent,
                         int rules) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);  // it ended before prctl()
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD})
    ::signal(signal_number, SIG_DFL);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  for (int file = 0; file < 3; ++file) ::dup2(standard[std::size_t(file)], file);
  if (rules >= 0) {
    ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    ::syscall(SYS_landlock_restrict_self, rules, 0);
  }
  ::execvp(words[0], words);
  const int why = errno;
  [[maybe_unused]] const ssize_t written = ::write(report, &why, sizeof why);
  ::_exit(127);
}

/// The supervisor's report when the program ends.
struct Ended {
  int status;
  rusage used;
};

// Kills the children of this process until none is left. This process adopts the children of each killed one.
void kill_descendants() {
  for (pid_t reaped = 0; reaped >= 0 || errno == EINTR; reaped = ::waitpid(-1, nullptr, WNOHANG)) {
    std::array<char, 4096> text;
    const int file = ::open("/proc/thread-self/children", O_RDONLY | O_CLOEXEC);
    if (file < 0) return;  // the kernel does not have this file
    const ssize_t bytes = ::read(file, text.data(), text.size());
    ::close(file);
    pid_t child = 0;
    for (ssize_t i = 0; i < bytes; ++i) {
      const char c = text[std::size_t(i)];
      if (c != ' ') {
        child = 10 * child + (c - '0');
      } else if (child > 1) {
        ::kill(child, SIGKILL);
        child = 0;
      }
    }
    if (reaped == 0) ::poll(nullptr, 0, 1);
  }
}

extern "C" void wake(int) {}

// Reports the program's end. When the parent ends, kills the program and all processes that it started,
// including those that called setsid. After fork, only async-signal-safe calls are allowed.
[[noreturn]] void supervise(pid_t program, int alive, int report) {
  ::dup2(alive, 0);
  ::dup2(report, 1);
  ::close_range(2, ~0U, 0);
  sigset_t all_but_child;
  ::sigfillset(&all_but_child);
  ::sigdelset(&all_but_child, SIGCHLD);
  Ended ended{};
  bool reported = false;
  const auto reap = [&](int options) {
    if (reported || ::wait4(program, &ended.status, options, &ended.used) != program) return;
    [[maybe_unused]] const ssize_t written = ::write(1, &ended, sizeof ended);
    reported = true;
  };
  for (pollfd parent{0, POLLIN, 0};;) {
    reap(WNOHANG);
    if (::ppoll(&parent, 1, nullptr, &all_but_child) > 0) break;  // SIGCHLD interrupts it
  }
  ::kill(-program, SIGKILL);
  if (!reported) ::kill(program, SIGKILL);
  reap(0);
  kill_descendants();
  ::_exit(0);
}

// Starts the program under a supervisor, which adopts everything that the program starts.
[[noreturn]] void start(char* const* words, const std::array<int, 3>& standard, int failure, int alive,
                        int report, int rules) {
  sigset_t all;
  ::sigfillset(&all);
  ::sigprocmask(SIG_SETMASK, &all, nullptr);
  struct sigaction on_child {};
  on_child.sa_handler = wake;
  ::sigaction(SIGCHLD, &on_child, nullptr);
  ::setpgid(0, 0);
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  const pid_t self = ::getpid(), program = ::fork();
  if (program == 0) become(words, standard, failure, self, rules);
  const int why = errno;
  [[maybe_unused]] ssize_t written = ::write(report, &program, sizeof program);
  if (program > 0) supervise(program, alive, report);
  written = ::write(failure, &why, sizeof why);
  ::_exit(0);
}

std::string ended_text(int status) {
  if (WIFSIGNALED(status))
    return fmt::format("it was killed by signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  return fmt::format("it ended with exit code {}", WEXITSTATUS(status));
}

/// Reads a whole structure. Returns false at the end of the file or if there is nothing to read yet.
template <class Structure>
bool read_whole(int file, Structure& structure) {
  ssize_t got = 0;
  while ((got = ::read(file, &structure, sizeof structure)) < 0 && errno == EINTR) continue;
  return got == sizeof structure;
}

}  // namespace

std::filesystem::path program_file(const std::string& word) {
  const char* const path = std::getenv("PATH");
  if (word.find('/') != word.npos) return absolute(std::filesystem::path(word)).lexically_normal();
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const auto file = std::filesystem::path(folder.empty() ? "." : folder) / word;
        ::access(file.c_str(), X_OK) == 0)
      return file;
  return word;
}

std::string missing_interpreter(const std::filesystem::path& program) {
  std::ifstream file(program);
  std::string mark(2, ' '), line;
  if (!file.read(mark.data(), 2) || mark != "#!" || !std::getline(file, line)) return "";
  line.erase(0, line.find_first_not_of(" \t"));
  line.erase(std::min(line.find_first_of(" \t"), line.size()));
  return ::access(line.c_str(), F_OK) == 0 ? "" : line;
}

std::string start_fault(const std::string& role, const std::filesystem::path& program, int why) {
  std::string cause = std::strerror(why), interpreter = missing_interpreter(program);
  if (const bool windows = interpreter.ends_with('\r'); !interpreter.empty()) {
    if (windows) interpreter.replace(interpreter.size() - 1, 1, "\\r");
    cause = fmt::format("its first line names the interpreter '{}', which does not exist{}", interpreter,
                        windows ? ": the lines end with CR LF, expected LF" : "");
  }
  return fmt::format("{}: the program {} cannot be started: {}", role, program.string(), cause);
}

std::string printable(std::string_view text) {
  std::string line;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (text.substr(i, 2) == "\x1B[") {
      i = std::min(text.find_first_not_of("0123456789:;<=>? !\"#$%&'()*+,-./", i + 2), text.size());
      continue;
    }
    const bool blank = c == '\n' || c == '\t' || c == '\r';
    line += blank ? ' ' : c >= ' ' && c <= '~' ? c : '?';
  }
  return line;
}

TimeLimit::TimeLimit(double within_s)
    : seconds(within_s),
      deadline(Clock::now() +
               std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(within_s))) {}

ChildProgram::ChildProgram(const std::vector<std::string>& words, const std::string& role,
                           const std::filesystem::path& writable) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  Ends in, out, error, failure, alive, report;
  // A socket: writing to a closed one is an error, not a signal.
  bool made = ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, in.file.data()) == 0;
  ::setsockopt(in.file[0], SOL_SOCKET, SO_SNDBUF, &kBuffer, sizeof kBuffer);
  for (Ends* const ends : {&out, &error, &failure, &alive, &report})
    made = made && ::pipe2(ends->file.data(), O_CLOEXEC) == 0;
  const int rules = rules_of(writable);
  supervisor_ = made ? ::fork() : -1;
  if (supervisor_ < 0)
    throw std::invalid_argument(
        fmt::format("{}: no process could be created for the program: {}", role, std::strerror(errno)));
  if (supervisor_ == 0)
    start(arguments.data(), {in.file[1], out.file[1], error.file[1]}, failure.file[1], alive.file[0],
          report.file[1], rules);
  ::close(rules), ::close(failure.release(1)), ::close(report.release(1));
  const bool started = read_whole(report.file[0], process_);
  int why = started ? 0 : ESRCH;
  const bool failed = read_whole(failure.file[0], why) || !started;
  in_ = in.release(0), out_ = out.release(0), error_ = error.release(0);
  alive_ = alive.release(1), report_ = report.release(0);
  for (const int file : {in_, out_, error_, report_}) ::fcntl(file, F_SETFL, O_NONBLOCK);
  if (!failed) return;
  kill();
  for (const int file : {in_, out_, error_, report_}) ::close(file);
  const bool has_arguments = words.size() == 1 && words[0].find(' ') != std::string::npos;
  throw std::invalid_argument(
      start_fault(role, program_file(words[0]), why) +
      (has_arguments ? "; its arguments are words of a list, as in [./my_slam, --stdio]" : ""));
}

ChildProgram::~ChildProgram() {
  kill();
  for (const int file : {in_, out_, error_, report_})
    if (file >= 0) ::close(file);
}

void ChildProgram::send(std::string_view bytes, const TimeLimit& limit) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(in_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent >= 0)
      bytes.remove_prefix(std::size_t(sent));
    else if (ended_ || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR))
      fail_ended();
    else if (!wait_for(in_, POLLOUT, limit))
      throw ProgramFailed(fmt::format("it did not read its input within {} s", limit.seconds));
  }
}

std::string ChildProgram::receive(std::size_t bytes, const TimeLimit& limit) {
  std::string received(bytes, '\0');
  for (std::size_t at = 0; at < bytes;) {
    const ssize_t got = ::read(out_, received.data() + at, bytes - at);
    if (got > 0)
      at += std::size_t(got);
    else if (got == 0 || ended_ || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR))
      fail_ended(at == 0 ? "" : fmt::format(" after {} of {} bytes of a message", at, bytes));
    else if (!wait_for(out_, POLLIN, limit))
      throw ProgramFailed(
          at == 0 ? fmt::format("no answer within {} s", limit.seconds)
                  : fmt::format("only {} of {} bytes of a message within {} s", at, bytes, limit.seconds));
  }
  return received;
}

std::string ChildProgram::unread() {
  std::string bytes(4096, '\0');
  bytes.resize(std::size_t(std::max<ssize_t>(0, ::read(out_, bytes.data(), bytes.size()))));
  return bytes;
}

// Meanwhile reads the program's standard error, so that writing to it does not block, and checks whether the
// program has ended, because processes that it started may keep its output open. Kills it at the time limit.
bool ChildProgram::wait_for(int file, short events, const TimeLimit& limit) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(limit.deadline - Clock::now());
  if (left.count() <= 0) {
    kill();
    read_log();
    return false;
  }
  std::array files{pollfd{file, events, 0}, pollfd{error_, POLLIN, 0}, pollfd{report_, POLLIN, 0}};
  ::poll(files.data(), files.size(), int(std::min<long long>(left.count(), 1000)));
  if (files[1].revents != 0) read_log();
  has_ended();
  return true;
}

void ChildProgram::read_log() {
  std::array<char, 1 << 14> buffer;
  ssize_t got = 0;
  while (error_ >= 0 && (got = ::read(error_, buffer.data(), buffer.size())) != 0) {
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return;
    log_.append(buffer.data(), std::size_t(got));
    if (log_.size() <= 2 * kMostLog) continue;
    log_lost_ += log_.size() - kMostLog;
    log_.erase(0, log_.size() - kMostLog);
  }
  if (error_ >= 0) ::close(error_);
  error_ = -1;
}

bool ChildProgram::has_ended() {
  Ended ended{};
  if (ended_ || !read_whole(report_, ended)) return ended_;
  const auto ms = [](const timeval& time) { return 1e3 * double(time.tv_sec) + 1e-3 * double(time.tv_usec); };
  status_ = ended.status;
  whole_cpu_ms_ = ms(ended.used.ru_utime) + ms(ended.used.ru_stime);
  return ended_ = true;
}

bool ChildProgram::wait_until_ended(const TimeLimit& limit) {
  while (!has_ended() && Clock::now() < limit.deadline) {
    read_log();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  read_log();
  return has_ended();
}

void ChildProgram::fail_ended(const std::string& progress) {
  const bool ended = wait_until_ended(TimeLimit(kToEnd_s));
  kill();
  throw ProgramFailed((ended ? ended_text(status_) : "it closed its standard input or output") + progress);
}

// Kills the program and all processes that it started.
void ChildProgram::kill() {
  if (alive_ < 0) return;
  ::close(std::exchange(alive_, -1));
  while (::waitpid(supervisor_, nullptr, 0) < 0 && errno == EINTR) continue;
  if (!has_ended()) status_ = SIGKILL, ended_ = true;  // the supervisor was killed, and the program with it
}

void ChildProgram::run(const TimeLimit& limit) {
  end(limit);
  if (WIFSIGNALED(status_) && WTERMSIG(status_) == SIGKILL && Clock::now() >= limit.deadline)
    throw ProgramFailed(fmt::format("it did not exit within {} s", limit.seconds));
  if (const std::string fault = exit_fault(); !fault.empty()) throw ProgramFailed(fault);
}

bool ChildProgram::end(const TimeLimit& limit) {
  if (in_ >= 0) ::close(std::exchange(in_, -1));
  const bool ended = wait_until_ended(limit);
  kill();
  read_log();
  return ended;
}

std::string ChildProgram::exit_fault() const {
  return WIFEXITED(status_) && WEXITSTATUS(status_) == 0 ? "" : ended_text(status_);
}

std::string ChildProgram::log() const {
  if (log_.size() <= kMostLog && log_lost_ == 0) return log_;
  const std::size_t kept = std::min(log_.size(), kMostLog);
  return fmt::format("(the first {} bytes are omitted)\n", log_lost_ + log_.size() - kept) +
         log_.substr(log_.size() - kept);
}

std::string ChildProgram::last_lines() {
  read_log();
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
  return 1e3 * double(used.tv_sec) + 1e-6 * double(used.tv_nsec);
}

}  // namespace sim::programs
