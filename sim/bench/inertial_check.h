// Whether the ideal gyro and accelerometer are what the robot's motion makes them: integrated from a true
// start they lead along the true path.
#pragma once

#include <deque>

#include "sim/stream/recording.h"
#include "slam/observation.h"

namespace sim::bench {

/// Integration by the trapezoidal rule: turns composed, the specific force turned by the mean of the
/// attitudes at both ends of its reading, the position along the mean of both velocities. Not the inverse of
/// the formula that makes the readings, which knows no position. A new integration begins at the truth every
/// 10 s and lasts 30 s.
class InertialCheck {
 public:
  explicit InertialCheck(const stream::TrueMotion& start);

  /// The next reading of both, and where it truly led.
  void take(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
            const stream::TrueMotion& end);

  double worst_position_m() const { return worst_position_m_; }
  double worst_yaw_rad() const { return worst_yaw_rad_; }

 private:
  void compare(const stream::TrueMotion& integrated, const stream::TrueMotion& truth);

  std::deque<stream::TrueMotion> integrations_;  // t: when each began
  double worst_position_m_ = 0, worst_yaw_rad_ = 0;
};

}  // namespace sim::bench
