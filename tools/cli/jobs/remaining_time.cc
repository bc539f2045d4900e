#include "tools/cli/jobs/remaining_time.h"

#include <algorithm>

namespace cli {
namespace {

constexpr double kBurst_s = 1, kLeastPart = 0.01, kLeast_s = 2;  // a rate over less says little
constexpr double kSlower = 1.3, kSlower_s = 5;                   // beyond which a job has become slower

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

}  // namespace cli
