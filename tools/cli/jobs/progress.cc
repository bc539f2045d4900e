#include "tools/cli/jobs/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <fstream>

namespace cli {
namespace {

constexpr std::chrono::milliseconds kRedraw{200};
constexpr double kBurst_s = 1, kLeastPart = 0.01, kLeast_s = 2;  // minima for a reliable rate
constexpr double kSlower = 1.3, kSlower_s = 5;                   // above these, a job has become slower

std::atomic<int> live_lines = 0;

std::string duration_text(double seconds) {
  const int whole = int(seconds + 0.5);
  return whole < 100 ? fmt::format("{} s", whole) : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

/// Returns the file named by the parent; the variable is not passed on to child processes.
fs::path file_of_parent() {
  static const fs::path file = [] {
    const char* const named = std::getenv(kProgressFile);
    const fs::path path = named ? named : "";
    ::unsetenv(kProgressFile);
    return path;
  }();
  return file;
}

}  // namespace

std::optional<double> RemainingTime::at(double part, double spent_s) {
  if (spent_s < kBurst_s) return std::nullopt;
  if (!first_) first_ = last_ = Point{part, spent_s};
  const double done = part - first_->part, took_s = spent_s - first_->spent_s;
  if (part > last_->part && done >= kLeastPart && took_s >= kLeast_s) {
    end_s_ = spent_s + took_s * (1 - part) / done;
    last_ = Point{part, spent_s};
  }
  if (!end_s_) return std::nullopt;
  const double left_s = std::max(0.0, *end_s_ - spent_s);
  if (!shown_s_ || left_s < *shown_s_ || left_s > kSlower * *shown_s_ + kSlower_s) shown_s_ = left_s;
  return shown_s_;
}

std::string progress_text(const std::string& what, std::optional<double> part, double spent_s,
                          std::optional<double> left_s, const std::string& at) {
  std::string text = what + ": ";
  text += part ? fmt::format("{:.0f} %", std::floor(100 * *part)) : duration_text(spent_s);
  if (left_s) text += fmt::format(", {} left", duration_text(*left_s));
  return at.empty() ? text : text + "; " + at;
}

double part_in(const fs::path& file) {
  double part = 0;
  std::ifstream(file) >> part;
  return std::clamp(part, 0.0, 1.0);
}

ProgressPlace ProgressPlace::standard() {
  return {
      .redraws = can_redraw(STDERR_FILENO), .silent = output() == Output::quiet, .file = file_of_parent()};
}

ProgressLine::ProgressLine(std::string what, const ProgressPlace& place)
    : what_(std::move(what)),
      place_(place),
      outermost_(live_lines++ == 0),
      thread_([this](const std::stop_token& stop) { draw_until(stop); }) {}

ProgressLine::~ProgressLine() {
  thread_.request_stop();
  thread_.join();
  --live_lines;
  if (drawn_) std::fputs("\r\033[K", place_.stream);
}

void ProgressLine::show(double part, const std::string& at) {
  const std::lock_guard lock(mutex_);
  part_ = std::max(part, part_.value_or(0));
  at_ = at;
}

void ProgressLine::draw_until(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (
      !wake_.wait_for(lock, stop, std::min(kRedraw, place_.heartbeat), [&] { return stop.stop_requested(); }))
    draw(std::chrono::duration<double>(Clock::now() - begin_).count());
}

void ProgressLine::draw(double spent_s) {
  if (!outermost_) return;
  if (!place_.file.empty()) {
    if (part_) std::ofstream(place_.file) << fmt::format("{:.4f}\n", *part_);
    return;
  }
  const auto left_s = part_ ? remaining_.at(*part_, spent_s) : std::nullopt;
  const auto now = Clock::now();
  if (place_.silent || now - begin_ < place_.first) return;
  const std::string text = progress_text(what_, part_, spent_s, left_s, at_);
  if (place_.redraws) {
    struct winsize size {};
    const bool known = ::ioctl(fileno(place_.stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    fmt::print(place_.stream, "\r\033[K{}", text.substr(0, (known ? size.ws_col : 80U) - 1));
    drawn_ = true;
  } else if (now - last_beat_ >= place_.heartbeat) {
    fmt::print(place_.stream, "gaitslam: {}\n", text);
    last_beat_ = now;
  }
  std::fflush(place_.stream);
}

}  // namespace cli
