// Progress of a command: a single line on a terminal, otherwise a new line every half minute.
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

/// Estimates the remaining time from the average rate after the first second. Counts down between updates and
/// increases only if the job has become much slower.
class RemainingTime {
 public:
  /// Returns the remaining time (s), or nullopt until a rate is known. part: done; spent_s must not decrease.
  std::optional<double> at(double part, double spent_s);

 private:
  struct Point {
    double part = 0, spent_s = 0;
  };
  std::optional<Point> first_, last_;
  /// Time when the job will be done; the last returned remaining time.
  std::optional<double> end_s_, shown_s_;
};

/// Returns "walk seed 1: 42 %, 8 s left; search", or "walk seed 1: 3 min 05 s" if the fraction is unknown.
std::string progress_text(const std::string& what, std::optional<double> part, double spent_s,
                          std::optional<double> left_s, const std::string& at);

/// Environment variable with the file in which to report progress to the parent process.
inline constexpr const char* kProgressFile = "GAITSLAM_PROGRESS_FILE";
/// Returns the fraction that a process has written there; 0 before the first.
double part_in(const fs::path& file);

/// The destination and form of a progress line.
struct ProgressPlace {
  bool redraws = false;  ///< redraws a single line
  bool silent = false;
  fs::path file{};  ///< if not empty, progress goes to this file for the parent process, and nothing is shown
  std::FILE* stream = stderr;
  std::chrono::milliseconds first{1000}, heartbeat{30'000};

  /// Returns the settings for standard error, whether or not it is a terminal; silent with --quiet.
  static ProgressPlace standard();
};

/// Shows progress from its own thread, so that it also updates while the work is blocked. If there are
/// several, only the first is shown.
class ProgressLine {
 public:
  /// what: text at the start of the line.
  explicit ProgressLine(std::string what, const ProgressPlace& place = ProgressPlace::standard());
  /// Removes the line from the terminal.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Sets the fraction that is done, 0 to 1, and the current step. A fraction never decreases.
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
  std::jthread thread_;  ///< the last member, so that it ends before the others are destroyed
};

}  // namespace cli
