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
  readings.gyro.y() = 0.002;  // so slowly that the feet seem at rest in each tick
  for (int k = 0; k < 20; ++k) {
    readings.accelerometer.setZero();  // so that it does not correct the tilt
    points.add(readings), soles.add(readings);
  }
  const Eigen::Vector3d p_BT =
      sole_in_base(robot, Side::left, leg_angles(leg, readings.q)) * Eigen::Vector3d(toe, 0, 0);
  const Eigen::AngleAxisd turn(0.002 * 20 * kPeriod, Eigen::Vector3d::UnitY());
  const LegOdometry::Motion rolled = points.motion(readings.q);
  EXPECT_LT((rolled.X_OB * p_BT - X_OB * p_BT).norm(), 0.05 * turn.angle() * robot.base_height);
  EXPECT_LT((rolled.X_OB.linear() - turn.toRotationMatrix()).norm(), 1e-9);
  EXPECT_LT((rolled.p_OS - X_OB * p_BT).norm(), 0.05 * turn.angle() * robot.base_height);
  EXPECT_LT((soles.motion(readings.q).X_OB.linear() - X_OB.linear()).norm(), 1e-6);
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

TEST(LegOdometry, TheDeflectionOfABushMovesTheWaistOnAnyFloor) {
  Robot robot = made_up_robot();
  for (Leg& leg : robot.legs) leg.bush = {{false, Eigen::Vector3d::UnitX(), 1e4}};
  LegOdometry legs(robot, Eigen::Isometry3d::Identity(), Floor::any);
  SensorReadings readings = loaded(robot, 300, 0, 0);
  legs.add(readings);
  readings.left.force.x() = 0.04;  // the ground pushes the sole ahead by 4 um
  for (int k = 0; k < 20; ++k) legs.add(readings);
  EXPECT_NEAR(legs.motion(readings.q).X_OB.translation().x(), -4e-6, 1e-8);
}

/// Leg odometry of a robot whose knees move the soles forward or backward in the waist's axes.
class Sliding {
 public:
  Sliding() { legs_.add(readings(1, 1)); }
  /// Ticks with these loads, in each of which the knees turn by these angles while the waist keeps its
  /// velocity. Returns how far the waist moves in the last one.
  double walk(int ticks, double left_n, double right_n, double left_rad, double right_rad) {
    for (int k = 1; k < ticks; ++k) walk(1, left_n, right_n, left_rad, right_rad);
    const double before = legs_.motion(q_).X_OB.translation().x();
    q_[knee(Side::left)] += left_rad, q_[knee(Side::right)] += right_rad;
    legs_.add(readings(left_n, right_n));
    return legs_.motion(q_).X_OB.translation().x() - before;
  }
  /// The right foot stays at rest and carries the robot, as its knee turns more in each tick, until by 5
  /// mrad.
  double accelerate() {
    double moved = 0;
    for (int k = 1; k < 60; ++k) {
      const double before = right_sole();
      q_[knee(Side::right)] += 0.005 * k / 60;
      SensorReadings now = readings(0, 500);
      const double last = std::exchange(moved, before - right_sole());
      now.accelerometer.x() = (moved - last) / (kPeriod * kPeriod);
      legs_.add(now);
    }
    return walk(1, 0, 500, 0, 0.005);
  }

 private:
  int knee(Side side) const { return robot_.leg(side).joints[3]; }
  double right_sole() const {
    return sole_in_base(robot_, Side::right, leg_angles(robot_.leg(Side::right), q_)).translation().x();
  }
  SensorReadings readings(double left_n, double right_n) const {
    SensorReadings readings = loaded(robot_, left_n, right_n, 0);
    readings.q = q_;
    return readings;
  }

  const Robot robot_ = made_up_robot();
  LegOdometry legs_{robot_, Eigen::Isometry3d::Identity(), Floor::any};
  JointVector q_ = robot_.posture;
};

TEST(LegOdometry, FeetCountByTheirLoadUnlessItIsSmall) {
  const double slowly = 1e-6;  // a sole that does not slide
  const double alone = Sliding().walk(30, 300, 0, slowly, 0);
  EXPECT_LT(alone, -1e-8);
  EXPECT_NEAR(Sliding().walk(30, 300, 300, slowly, 0) / alone, 0.5, 1e-4);
  EXPECT_NEAR(Sliding().walk(30, 20, 480, slowly, 0) / alone, 0, 1e-4);
}

TEST(LegOdometry, AFootThatSlidesOnLandingDoesNotShortenTheWalk) {
  Sliding robot;
  const double before = robot.accelerate();
  ASSERT_GT(std::abs(before) / kPeriod, 0.3);  // m/s: it walks
  // The left foot carries 60 % of the load, and its sole follows the waist at 1.2 times its speed.
  EXPECT_NEAR(robot.walk(2, 300, 200, -0.001, 0.005) / before, 1, 0.03);
}

TEST(LegOdometry, IfAllFeetSlideTheWaistMovesAsTheAccelerometerTells) {
  Sliding robot;
  const double before = robot.accelerate();
  for (int k = 0; k < 20; ++k) EXPECT_NEAR(robot.walk(1, 500, 0, 0, 0) / before, 1, 0.02);
  EXPECT_NEAR(robot.walk(400, 500, 0, 0, 0) / before, 0, 1e-3) << "a foot that slides for long is at rest";
}

}  // namespace
}  // namespace walking
