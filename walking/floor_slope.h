// Walking on a slope with a plan for a level floor: the robot's own sensors measure the slope.
#pragma once

#include "walking/stabilizer.h"

namespace walking {

/// Estimates the slope from the tilt of the loaded soles (leg encoders and the IMU's vertical), and places
/// the soles of a posture on a plane with that slope under the waist.
class FloorSlope {
 public:
  explicit FloorSlope(const Robot& robot) : robot_(robot) {}

  /// Call once every kPeriod. tilt: roll and pitch of the waist, rad.
  void update(const Reference& reference, const Eigen::Vector2d& tilt, const SensorReadings& readings);
  Posture adapted(Posture posture) const;
  /// Rise in height per m along x and y of P.
  const Eigen::Vector2d& gradient() const { return gradient_; }

 private:
  Robot robot_;
  Eigen::Vector2d gradient_ = Eigen::Vector2d::Zero();
};

}  // namespace walking
