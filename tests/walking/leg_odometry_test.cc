#include "walking/leg_odometry.h"

#include "tests/walking/robots.h"
#include "walking/kinematics.h"

namespace walking {
namespace {

/// A robot in its start posture with these loads (N), each `ahead_m` ahead of the point of the sole below the
/// ankle.
SensorReadings loaded(const Robot& robot, double left_n, double right_n, double ahead_m) {
  SensorReadings readings;
  readings.q = robot.posture;
  readings.accelerometer.z() = kGravity;
  readings.left.force.z() = left_n, readings.right.force.z() = right_n;
  readings.left.torque.y() = -ahead_m * left_n, readings.right.torque.y() = -ahead_m * right_n;
  return readings;
}

TEST(LegOdometry, ARobotRollingOverItsToesTurnsAboutThemUnlessItsSolesLieFlat) {
  const Robot robot = made_up_robot();
  Robot with_pads = robot;
  for (Leg& leg : with_pads.legs) leg.pad_stiffness << 1e9, 1e9;
  const Leg& leg = robot.leg(Side::left);
  Eigen::Isometry3d X_OB = Eigen::Isometry3d::Identity();
  X_OB.translation().z() = robot.base_height;
  LegOdometry points(robot, X_OB, Floor::any), soles(with_pads, X_OB);
  const double toe = leg.sole_max.x();
  SensorReadings readings = loaded(robot, 300, 0, toe);
  points.add(readings), soles.add(readings);
  readings.gyro.y() = 0.5;
  for (int k = 0; k < 20; ++k) {
    readings.accelerometer.setZero();  // so that it does not correct the tilt
    points.add(readings), soles.add(readings);
  }
  const Eigen::Vector3d p_BT =
      sole_in_base(robot, Side::left, leg_angles(leg, readings.q)) * Eigen::Vector3d(toe, 0, 0);
  const Eigen::AngleAxisd turn(0.5 * 20 * kPeriod, Eigen::Vector3d::UnitY());
  const LegOdometry::Motion rolled = points.motion(readings.q);
  EXPECT_LT((rolled.X_OB * p_BT - X_OB * p_BT).norm(), 1e-9);
  EXPECT_LT((rolled.X_OB.linear() - turn.toRotationMatrix()).norm(), 1e-9);
  EXPECT_LT((rolled.p_OS - X_OB * p_BT).norm(), 1e-9);
  EXPECT_LT((soles.motion(readings.q).X_OB.linear() - X_OB.linear()).norm(), 0.02);
}

TEST(LegOdometry, SolesWithoutPadsTiltWithTheGyroAndStayOnALevelFloor) {
  const Robot robot = made_up_robot();
  Eigen::Isometry3d X_OB = Eigen::Isometry3d::Identity();
  X_OB.translation().z() = robot.base_height + 0.01;
  LegOdometry legs(robot, X_OB);
  SensorReadings readings = loaded(robot, 300, 0, 0);
  legs.add(readings);
  readings.gyro.x() = 0.02, readings.accelerometer.setZero();
  for (int k = 0; k < 200; ++k) legs.add(readings);
  const Eigen::Isometry3d now = legs.motion(readings.q).X_OB;
  EXPECT_NEAR(Eigen::AngleAxisd(now.linear()).angle(), 0.02, 1e-9);
  EXPECT_NEAR(legs.motion(readings.q).p_OS.z(), 0, 1e-5);
  EXPECT_NEAR(now.translation().y(), -0.02 * robot.base_height, 2e-3);
}

TEST(LegOdometry, MovesToAPlaceWithItsHeightAndTilt) {
  const Robot robot = made_up_robot();
  Robot with_pads = robot;
  for (Leg& leg : with_pads.legs) leg.pad_stiffness << 1e9, 1e9;
  for (const Robot& each : {robot, with_pads}) {
    LegOdometry legs(each, sole({{1, 2}, 3}, each.base_height));
    SensorReadings readings = loaded(each, 300, 0, 0);
    legs.add(readings);
    readings.gyro.x() = 0.02;
    legs.add(readings);
    const Eigen::Isometry3d before = legs.motion(readings.q).X_OB;
    const FootPose place{{0.3, -0.2}, 1.2};
    legs.move_to(place, readings.q);
    const Eigen::Isometry3d now = legs.motion(readings.q).X_OB;
    EXPECT_LT((on_floor(now).position - place.position).norm(), 1e-9);
    EXPECT_NEAR(on_floor(now).yaw, place.yaw, 1e-9);
    EXPECT_NEAR(now.translation().z(), before.translation().z(), 1e-9);
    EXPECT_LT((now.linear().row(2) - before.linear().row(2)).norm(), 1e-9);
  }
}

TEST(LegOdometry, AChestThatTurnsOnItsWaistDoesNotTurnTheWaist) {
  const Robot robot = made_up_robot();
  LegOdometry legs(robot, Eigen::Isometry3d::Identity(), Floor::any);
  SensorReadings readings = loaded(robot, 250, 250, 0);
  legs.add(readings);
  for (int k = 0; k < 20; ++k) {
    readings.gyro.z() = 0.4;
    readings.q[robot.chest] += 0.4 * kPeriod;
    legs.add(readings);
  }
  EXPECT_LT((legs.motion(readings.q).X_OB.matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-12);
}

TEST(LegOdometry, FeetCountByTheirLoadUnlessItIsSmall) {
  const Robot robot = made_up_robot();
  const auto ahead = [&](double left_n, double right_n) {
    LegOdometry legs(robot, Eigen::Isometry3d::Identity(), Floor::any);
    SensorReadings readings = loaded(robot, left_n, right_n, 0);
    legs.add(readings);
    readings.q[robot.leg(Side::left).joints[3]] += 0.002;  // only the left sole moves in the waist's axes
    legs.add(readings);
    return legs.motion(readings.q).X_OB.translation().norm();
  };
  EXPECT_GT(ahead(300, 0), 1e-4);
  EXPECT_NEAR(ahead(300, 300), ahead(300, 0) / 2, 1e-9);
  EXPECT_EQ(ahead(20, 480), 0);
}

}  // namespace
}  // namespace walking
