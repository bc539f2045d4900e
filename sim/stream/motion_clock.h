// The clock of the motion computer, which goes wrong by a constant: its readings and its plan reach the
// filter under stamps that are not those of the camera's clock.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "slam/observation.h"

namespace sim::stream {

/// Puts together what the vision computer believes to belong to a frame.
class MotionClock {
 public:
  /// offset: how much later the motion computer's stamps are than the vision computer's, of the same moment.
  explicit MotionClock(slam::Stamp offset) : offset_(offset) {}

  /// Takes an observation of true stamps; gives those that are complete by now. A clock that is behind keeps
  /// a frame waiting for its motion. A reading across a frame is split there; the plan is interpolated.
  std::vector<slam::Observation> take(slam::Observation observation);

  /// What still waits, with what motion there is.
  std::vector<slam::Observation> rest();

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

}  // namespace sim::stream
