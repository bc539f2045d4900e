// Ends a group of processes when this process has ended, however it did.
#pragma once

#include <sys/types.h>

namespace sim::estimators {

/// A process that waits for the end of this one: also SIGKILL leaves nothing of the watched group running.
class ProcessGuard {
 public:
  /// Throws std::invalid_argument where there can be no further process.
  ProcessGuard();
  ~ProcessGuard() { release(); }
  ProcessGuard(const ProcessGuard&) = delete;
  ProcessGuard& operator=(const ProcessGuard&) = delete;

  /// Once, here or in a process forked from this one: the group that is to end with this process. A function
  /// that a signal handler may call.
  void watch(pid_t group) const;
  /// The group is left alone from now on.
  void release();

 private:
  pid_t process_ = -1;
  int alive_ = -1;  // the end of a pipe that is open as long as this process lives
};

}  // namespace sim::estimators
