// One line on the terminal that says how far a run is and how long it will take; silent where there is no
// terminal.
#pragma once

#include <chrono>
#include <string>

namespace cli {

class ProgressLine {
 public:
  explicit ProgressLine(std::string what);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// part: what is done, 0 to 1; at: what is being done. Draws at most five times a second.
  void show(double part, const std::string& at = "");

 private:
  std::string what_;
  bool on_terminal_, drawn_ = false;
  std::chrono::steady_clock::time_point begin_, last_;
};

}  // namespace cli
