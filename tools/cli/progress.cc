#include "tools/cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace cli {
namespace {

using Clock = std::chrono::steady_clock;

std::string in_words(double seconds) {
  const int whole = static_cast<int>(seconds + 0.5);
  return whole < 100 ? fmt::format("{} s", whole) : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

}  // namespace

ProgressLine::ProgressLine(std::string what)
    : what_(std::move(what)), on_terminal_(isatty(STDERR_FILENO) == 1), begin_(Clock::now()), last_(begin_) {}

ProgressLine::~ProgressLine() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::show(double part, const std::string& at) {
  using std::chrono::duration;
  const auto now = Clock::now();
  if (!on_terminal_ || (drawn_ && now - last_ < std::chrono::milliseconds(200))) return;
  const double spent_s = duration<double>(now - begin_).count();
  const std::string left = part > 0.01 ? ", " + in_words(spent_s * (1 - part) / part) + " left" : "";
  fmt::print(stderr, "\r\033[K{}: {:.0f} %{}{}", what_, 100 * part, left, at.empty() ? "" : "; " + at);
  std::fflush(stderr);
  drawn_ = true;
  last_ = now;
}

}  // namespace cli
