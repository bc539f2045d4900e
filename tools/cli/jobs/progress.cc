#include "tools/cli/jobs/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace cli {

using Clock = std::chrono::steady_clock;

std::string duration_text(double seconds) {
  const int whole = static_cast<int>(seconds + 0.5);
  return whole < 100 ? fmt::format("{} s", whole) : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

ProgressLine::ProgressLine(std::string what)
    : what_(std::move(what)), on_terminal_(isatty(STDERR_FILENO) == 1), begin_(Clock::now()), last_(begin_) {}

ProgressLine::~ProgressLine() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::show(double part, const std::string& at) {
  const auto now = Clock::now();
  if (!on_terminal_ || (drawn_ && now - last_ < std::chrono::milliseconds(200))) return;
  const double spent_s = std::chrono::duration<double>(now - begin_).count();
  const std::string left = part > 0.01 ? ", " + duration_text(spent_s * (1 - part) / part) + " left" : "";
  last_ = now;
  show_text(fmt::format("{}: {:.0f} %{}{}", what_, 100 * part, left, at.empty() ? "" : "; " + at));
}

void ProgressLine::show_text(const std::string& text) {
  if (!on_terminal_) return;
  fmt::print(stderr, "\r\033[K{}", text);
  std::fflush(stderr);
  drawn_ = true;
}

}  // namespace cli
