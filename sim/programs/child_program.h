// A child process that exchanges messages over its standard input and output, within time limits.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace sim::programs {

/// The program crashed, missed a time limit or gave an invalid answer. what(): the cause.
class ProgramFailed : public std::runtime_error {
 public:
  explicit ProgramFailed(const std::string& cause, std::string its_log = "")
      : std::runtime_error(cause), log(std::move(its_log)) {}

  std::string log;  ///< output of the program on standard error
};

/// Returns the absolute path of a program: the path itself if it contains a slash, otherwise the one found
/// in PATH. Returns the word itself if it is not in PATH.
std::filesystem::path program_file(const std::string& word);

/// Returns the interpreter that a script's first line names if it does not exist, or "".
std::string missing_interpreter(const std::filesystem::path& program);

/// Returns "<role>: the program <file> cannot be started: <cause>". why: the value of errno.
std::string start_fault(const std::string& role, const std::filesystem::path& program, int why);

/// Returns external text as one line of printable ASCII characters, without terminal colors.
std::string printable(std::string_view text);

/// A time limit that starts now.
struct TimeLimit {
  explicit TimeLimit(double within_s);
  double seconds;
  std::chrono::steady_clock::time_point deadline;
};

/// A program under a supervising process. The program and all processes that it started, including those that
/// called setsid, are killed when it misses a time limit, at the end, or when this process ends, even by
/// SIGKILL.
class ChildProgram {
 public:
  /// words: the program, looked up in PATH, and its arguments. role: its name in messages. writable: the only
  /// folder in which it may change files, if the kernel supports Landlock; empty: anywhere. Throws
  /// std::invalid_argument if it cannot be started.
  ChildProgram(const std::vector<std::string>& words, const std::string& role,
               const std::filesystem::path& writable = {});
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;
  /// Throw ProgramFailed if the program ends or misses the time limit.
  void send(std::string_view bytes, const TimeLimit& limit);
  std::string receive(std::size_t bytes, const TimeLimit& limit);
  /// Returns and removes the program's standard output so far, at most 4 KiB.
  std::string unread();
  /// Closes the program's standard input, waits for it to exit and kills it at the time limit.
  /// Returns whether it exited by itself.
  bool end(const TimeLimit& limit);
  /// Runs a program without messages until it exits. Throws ProgramFailed if its exit code is not 0 or it
  /// misses the time limit.
  void run(const TimeLimit& limit);
  /// Returns "it ended with exit code 7", or "" if it is 0. end() must have been called.
  std::string exit_fault() const;
  /// Returns the program's output on standard error, or the last MiB of it.
  std::string log() const;
  /// Returns the last lines of the log so far, for a message; empty if there are none.
  std::string last_lines();
  /// Returns the program's CPU time (ms); after its exit this includes its children's.
  double cpu_ms() const;

 private:
  [[noreturn]] void fail_ended(const std::string& progress = "");
  bool wait_for(int file, short events, const TimeLimit& limit);
  void read_log();
  bool has_ended();
  bool wait_until_ended(const TimeLimit& limit);
  void kill();

  pid_t supervisor_ = -1, process_ = -1;
  int alive_ = -1;                       // stays open while this process runs; closing it kills the program
  int report_ = -1;                      // how the program ended
  int in_ = -1, out_ = -1, error_ = -1;  // our ends of the program's standard input, output and error
  int status_ = 0;                       // from waitpid(), once ended_
  double whole_cpu_ms_ = 0;              // once ended_
  bool ended_ = false;
  std::string log_;
  std::size_t log_lost_ = 0;  // bytes removed from the front of log_
};

}  // namespace sim::programs
