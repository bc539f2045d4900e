// The self check of the ideal gyro and accelerometer: integrated from a true start they must lead along the
// true path.
#pragma once

#include <deque>

#include "sim/recording/recording.h"
#include "slam/observation.h"

namespace sim::live {

/// Integration by the trapezoidal rule: turns composed, the specific force turned by the mean of the
/// attitudes at both ends of its reading, the position along the mean of both velocities. Not the inverse of
/// the formula that makes the readings, which knows no position. A new integration begins at the truth every
/// 10 s and lasts 30 s; all begin anew after a reading of more than 50 m/s², as in a violent push or a fall,
/// because the mean over a reading does not tell how a blow is spread within it.
class InertialCheck {
 public:
  explicit InertialCheck(const recording::TrueMotion& start);

  /// The next reading of both, and where it truly led.
  void add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
           const recording::TrueMotion& end);

  double worst_position_m() const { return worst_position_m_; }
  double worst_yaw_rad() const { return worst_yaw_rad_; }
  /// Duration of the longest integration.
  slam::Stamp longest() const { return longest_; }

 private:
  void compare(const recording::TrueMotion& integrated, const recording::TrueMotion& truth);

  std::deque<recording::TrueMotion> integrations_;  // t: when each began
  slam::Stamp longest_{0};
  double worst_position_m_ = 0, worst_yaw_rad_ = 0;
};

}  // namespace sim::live
