// Walking on a slope by a plan for a level floor: the robot's own sensors give the slope.
#pragma once

#include "walking/stabilizer.h"

namespace walking {

/// Estimates the slope by the tilt of the loaded soles (encoders of the legs, vertical of the IMU), and puts
/// the soles of a posture on a plane of that slope under the waist.
class FloorSlope {
 public:
  explicit FloorSlope(const Robot& robot) : robot_(robot) {}

  /// Once every kPeriod. tilt: roll and pitch of the waist, rad.
  void update(const Reference& reference, const Eigen::Vector2d& tilt, const SensorReadings& readings);
  Posture adapted(Posture posture) const;
  /// Height for each m along x and y of P.
  const Eigen::Vector2d& gradient() const { return gradient_; }

 private:
  Robot robot_;
  Eigen::Vector2d gradient_ = Eigen::Vector2d::Zero();
};

}  // namespace walking
