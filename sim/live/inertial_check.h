// The self check of the ideal gyro and accelerometer: integrated from a true start they must lead along the
// true path.
#pragma once

#include <deque>

#include "sim/recording/recording.h"
#include "slam/observation.h"

namespace sim::live {

/// Integration by the trapezoidal rule: turns composed, the specific force turned by the mean of the
/// attitudes at both ends of its reading, the position along the mean of both velocities. Not the inverse of
/// the formula of the readings, which does not use positions. A new integration starts at the truth every 10
/// s and lasts 30 s; all restart after a reading of more than 50 m/s², as in a violent push or a fall,
/// because a mean does not show how a blow is distributed.
class InertialCheck {
 public:
  explicit InertialCheck(const recording::TrueMotion& start);

  /// The next reading of both, and the true motion at its end.
  void add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
           const recording::TrueMotion& end);

  double worst_position_m() const { return worst_position_m_; }
  double worst_yaw_rad() const { return worst_yaw_rad_; }
  /// Duration of the longest integration.
  slam::Stamp longest() const { return longest_; }

 private:
  void compare(const recording::TrueMotion& integrated, const recording::TrueMotion& truth);

  std::deque<recording::TrueMotion> integrations_;  // t: start of each
  slam::Stamp longest_{0};
  double worst_position_m_ = 0, worst_yaw_rad_ = 0;
};

}  // namespace sim::live
