#include "slam/plan_watch.h"

#include <cmath>

namespace slam {

PlanWatch::PlanWatch(const Options& options)
    : bound_(options.tracking.plan_bound),
      enabled_(options.plan_velocity.enabled && options.accelerometer.enabled && options.vision.enabled) {}

void PlanWatch::take(const ScaleEvidence& evidence) {
  sum_.score += evidence.score;
  sum_.information += evidence.information;
}

double PlanWatch::sigmas() const { return sum_.information > 0 ? sum_.score / std::sqrt(sum_.information) : 0; }

std::string PlanWatch::suspect() const {
  const double found = sigmas();
  if (!enabled_ || !(std::abs(found) > bound_)) return "";
  return std::string("plan: its distances are too ") + (found > 0 ? "long" : "short") + " by " +
         std::to_string(std::lround(std::abs(found))) + " standard deviations of the innovations";
}

}  // namespace slam
