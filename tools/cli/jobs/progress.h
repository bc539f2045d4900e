// A progress line on the terminal; silent where standard error is no terminal.
#pragma once

#include <chrono>
#include <string>

namespace cli {

/// "42 s", or "3 min 05 s" from 100 s on.
std::string duration_text(double seconds);

class ProgressLine {
 public:
  /// what: begins the line that show() draws.
  explicit ProgressLine(std::string what);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Draws the part that is done, 0 to 1, the time left and, if given, what is being done; at most five times
  /// a second.
  void show(double part, const std::string& at = "");
  /// Draws a line of the caller's own.
  void show_text(const std::string& text);

 private:
  std::string what_;
  bool on_terminal_, drawn_ = false;
  std::chrono::steady_clock::time_point begin_, last_;
};

}  // namespace cli
