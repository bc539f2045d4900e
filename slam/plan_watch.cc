#include "slam/plan_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slam {
namespace {

constexpr double kLeastSigmas = 6;

}  // namespace

PlanWatch::PlanWatch(const Options& options)
    : least_error_(options.tracking.plan_error),
      enabled_(options.plan_velocity.enabled && options.accelerometer.enabled && options.vision.enabled) {}

void PlanWatch::take(const ScaleEvidence& evidence) {
  sum_.score += evidence.score;
  sum_.information += evidence.information;
}

double PlanWatch::error() const { return sum_.information > 0 ? sum_.score / sum_.information : 0; }

double PlanWatch::sigma() const {
  return sum_.information > 0 ? 1 / std::sqrt(sum_.information) : std::numeric_limits<double>::infinity();
}

std::string PlanWatch::suspect() const {
  const double delta = error();
  if (!enabled_ || std::abs(delta) < kLeastSigmas * sigma()) return "";
  const double too_long = delta < 1 ? delta / (1 - delta) : std::numeric_limits<double>::infinity();
  if (std::abs(too_long) < least_error_) return "";
  const double percent = std::min(std::abs(too_long), 9.99) * 100;
  return "plan: its distances are about " + std::to_string(std::lround(percent)) + " % too " +
         (too_long > 0 ? "long" : "short") + " by the other sensors";
}

}  // namespace slam
