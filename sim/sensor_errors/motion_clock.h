// The clock of the motion computer, which is off by a constant: its readings and its plan reach the filter
// with stamps that are not those of the camera's clock.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "slam/observation.h"

namespace sim::sensor_errors {

/// Assembles the observations of the vision computer, which takes the motion computer's stamps for right.
class MotionClock {
 public:
  /// offset: how much later the motion computer's stamps are than the vision computer's, of the same moment.
  explicit MotionClock(slam::Stamp offset) : offset_(offset) {}

  /// Takes an observation with true stamps and returns those that are complete by now: with a clock that is
  /// behind, a frame waits for its motion. A reading across a frame is split there; the plan is interpolated.
  std::vector<slam::Observation> process(slam::Observation observation);

  /// The frames that still wait, with the motion known so far.
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
