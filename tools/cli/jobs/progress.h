// The progress of a command: one line on the terminal; elsewhere a line every half minute.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "tools/cli/shared/terminal.h"

namespace cli {

/// Estimates the time left from the average rate after the first second. Counts down between two steps, and
/// grows only if the job has become much slower.
class RemainingTime {
 public:
  /// Returns the time left, s, or nullopt before a rate is known, at a part done and an ascending time spent.
  std::optional<double> at(double part, double spent_s);

 private:
  struct Point {
    double part = 0, spent_s = 0;
  };
  std::optional<Point> first_, last_;
  std::optional<double> end_s_, shown_s_;  ///< when the job will be done; the time left as last returned
};

/// Returns "walk seed 1: 42 %, 8 s left; search", or "walk seed 1: 3 min 05 s" if the part is not known.
std::string progress_text(const std::string& what, std::optional<double> part, double spent_s,
                          std::optional<double> left_s, const std::string& at);

/// The variable that names the file for reporting progress to the parent process.
inline constexpr const char* kProgressFile = "GAITSLAM_PROGRESS_FILE";
/// Returns the part that a process has written there; 0 before it wrote any.
double part_in(const fs::path& file);

/// The place of a progress line.
struct ProgressPlace {
  bool redraws = false;  ///< one line, drawn again and again
  bool silent = false;
  fs::path file{};  ///< for the parent process, and nothing is shown; else empty
  std::FILE* stream = stderr;
  std::chrono::milliseconds first{1000}, heartbeat{30'000};

  /// Returns the place for standard error, of a terminal or not; silent with --quiet.
  static ProgressPlace standard();
};

/// Shows progress, drawn by its own thread: it moves while the work waits. Only the first of several is
/// shown.
class ProgressLine {
 public:
  /// what: the start of the line.
  explicit ProgressLine(std::string what, const ProgressPlace& place = ProgressPlace::standard());
  /// Removes the line from the terminal.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Shows the part that is done, 0 to 1, and the current step. A smaller part than before is not shown.
  void show(double part, const std::string& at = "");

 private:
  using Clock = std::chrono::steady_clock;

  void draw_until(const std::stop_token& stop);
  void draw(double spent_s);

  std::string what_, at_;
  ProgressPlace place_;
  std::optional<double> part_;
  RemainingTime remaining_;
  bool outermost_, drawn_ = false;
  Clock::time_point begin_ = Clock::now(), last_beat_ = begin_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;  ///< last: it ends before the other members
};

}  // namespace cli
