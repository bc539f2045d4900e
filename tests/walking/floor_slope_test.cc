#include "walking/floor_slope.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/walking/robots.h"
#include "walking/kinematics.h"

namespace walking {
namespace {

/// The slope (rise along x and y) after a robot on its left foot has had this roll and pitch (rad) for 0.6 s,
/// and then the opposite ones, again and again for 12 s.
Eigen::Vector2d slope_after(const Eigen::Vector2d& tilt, double opposite) {
  const Robot robot = made_up_robot();
  FloorSlope slope(robot);
  SensorReadings readings;
  readings.q = robot.posture;
  readings.left.force.z() = robot.mass * kGravity;
  const Eigen::Matrix3d level =
      sole_in_base(robot, Side::left, leg_angles(robot.leg(Side::left), robot.posture)).linear();
  Reference reference;
  reference.X_PB.linear() = level.transpose();
  for (int tick = 0; tick < 2400; ++tick)
    slope.update(reference, tick / 120 % 2 == 0 ? tilt : opposite * tilt, readings);
  return slope.gradient();
}

TEST(FloorSlope, FollowsALastingTiltOfTheSolesAndHardlyTheirSway) {
  const Eigen::Vector2d uphill(0, -0.1), sway(0.018, 0);
  EXPECT_NEAR(slope_after(uphill, 1).x(), std::tan(0.1), 0.005);
  EXPECT_LT(slope_after(sway, -1).norm(), 0.004);
}

}  // namespace
}  // namespace walking
