// The clock of the motion computer with a constant offset: its readings and plan reach the filter with wrong
// stamps.
#pragma once

#include <deque>

#include "slam/observation.h"

namespace sim::sensor_errors {

/// Assembles the observations of the vision computer, which trusts the motion computer's stamps.
class MotionClock {
 public:
  /// offset: stamps of the motion computer minus those of the vision computer at the same time.
  explicit MotionClock(slam::Stamp offset) : offset_(offset) {}

  /// Adds an observation with true stamps and returns the complete ones: if the clock is behind, frames wait
  /// for their motion. Readings across a frame are split; the plan is interpolated.
  std::vector<slam::Observation> process(slam::Observation observation);

  /// Returns the waiting frames with the motion known so far.
  std::vector<slam::Observation> flush();

 private:
  struct StampedPlan {
    slam::Stamp t{0};
    std::optional<slam::PlannedMotion> plan;
  };
  slam::Observation assembled();
  std::optional<slam::PlannedMotion> plan_at(slam::Stamp t);

  slam::Stamp offset_;
  std::deque<slam::Observation> waiting_;
  std::deque<slam::InertialSample> gyro_, accelerometer_;
  std::deque<StampedPlan> plans_;
};

}  // namespace sim::sensor_errors
