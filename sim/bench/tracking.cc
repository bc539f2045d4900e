#include "sim/bench/tracking.h"

#include <utility>

namespace sim::bench {

bool Tracked::diverged() const {
  return !frames.empty() && frames.back().report.health == slam::Health::diverged;
}

const std::string& Tracked::cause() const { return frames.back().report.cause; }

Tracking::Tracking(const Scenario& scenario, const slam::Calibration& calibration,
                   const Eigen::Isometry3d& X_WC_start)
    : errors_(scenario.errors, scenario.seed),
      filter_(*scenario.slam, calibration, X_WC_start, scenario.seed) {}

void Tracking::take(slam::Observation ideal) {
  if (tracked_.diverged()) return;
  const slam::FrameReport& report = filter_.step(errors_.apply(std::move(ideal)));
  tracked_.frames.push_back({filter_.estimate(), report});
}

Tracked Tracking::finish() {
  tracked_.map = filter_.map();
  return std::move(tracked_);
}

}  // namespace sim::bench
