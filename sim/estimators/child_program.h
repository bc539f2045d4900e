// A program that runs beside this one and is spoken to over its standard input and output, within time
// limits.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "sim/estimators/process_guard.h"

namespace sim::estimators {

/// Runs from its construction to its destruction, in a process group of its own. It is killed when it misses
/// a time limit, and dies with the thread that started it; its whole group dies with this process, however
/// that ends. What it writes to its standard error is kept. No result depends on the clock but through a
/// missed limit.
class ChildProgram {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  /// words: the program, found as a shell does, and its arguments. Throws std::invalid_argument where it
  /// cannot be started.
  explicit ChildProgram(const std::vector<std::string>& words);
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  /// Throw EstimatorFailed where the program ends before, or not until the deadline.
  void send(std::string_view bytes, Deadline deadline);
  std::string receive(std::size_t bytes, Deadline deadline);

  /// Closes its standard input, waits until it has ended, at most until the deadline, and kills it otherwise.
  void end(Deadline deadline);

  /// Waits until a program that is told nothing has ended. Throws EstimatorFailed where it has not until the
  /// deadline, or ends with another exit code than 0.
  void run(Deadline deadline);

  /// What it wrote to its standard error: all, or the end of it.
  std::string log() const;
  /// The last lines of that, for a message; empty if there are none.
  std::string last_lines() const;
  /// CPU time of its process so far, and once it has ended also of those that it waited for (ms).
  double cpu_ms() const;

 private:
  [[noreturn]] void fail_ended();
  void wait_for(int file, short events, Deadline deadline);
  void read_log();
  bool has_ended();
  bool reap(int options);
  void wait_until_ended(Deadline deadline);
  void kill();

  ProcessGuard guard_;
  pid_t process_ = -1;
  int in_ = -1, out_ = -1, error_ = -1;  // our ends of its standard input, output and error
  int status_ = 0;                       // as waitpid() gives it, once ended_
  double whole_cpu_ms_ = 0;              // once ended_
  bool ended_ = false, killed_ = false;
  std::string log_;
  std::size_t log_lost_ = 0;  // bytes that log_ does not hold any more
};

}  // namespace sim::estimators
