#include "walking/kinematics.h"

#include "tests/walking/walks.h"
#include "walking/leg_odometry.h"

namespace walking {
namespace {

TEST(InverseKinematics, StartFeetGiveTheStartJointsAndThePublishedAnklePosition) {
  const BodySolution body = inverse_kinematics(kRobot, standing(), kRobot.posture);
  EXPECT_TRUE(body.left_reached && body.right_reached);
  EXPECT_LT((body.q - kRobot.posture).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(kRobot.sole_ahead, .0094903511, 1e-10);  // as published by third parties
  EXPECT_NEAR(kRobot.base_height, 0.105 + .5437018512, 1e-10);
  EXPECT_NEAR(kRobot.foot_spacing, 0.19, 1e-15);
}

TEST(InverseKinematics, ALegThatCannotFollowIsNamedAndTheOtherFollows) {
  Posture posture = standing();
  posture.X_PL.translation() += Eigen::Vector3d(0.6, 0, -0.1);
  const BodySolution body = inverse_kinematics(kRobot, posture, kRobot.posture);
  EXPECT_FALSE(body.left_reached);
  EXPECT_TRUE(body.right_reached);
  EXPECT_TRUE(body.q.allFinite());
  EXPECT_THAT(leg_obstacle(kRobot, body), testing::Optional(testing::HasSubstr("left foot")));
  EXPECT_FALSE(leg_obstacle(kRobot, {kRobot.posture, true, true}).has_value());
}

using Eigen::Isometry3d, Eigen::Vector3d;

/// The readings of a robot that moves as planned; the load on its ankles is too small to make them yield.
SensorReadings readings_of(const Reference& reference) {
  SensorReadings readings;
  readings.q = inverse_kinematics(kRobot, reference, kRobot.posture).q;
  readings.left.force.z() = reference.support == Support::right ? 0 : 1e-3;
  readings.right.force.z() = reference.support == Support::left ? 0 : 1e-3;
  return readings;
}

/// A robot on its left foot, the right one high and tilted.
SensorReadings before_a_high_landing() {
  SensorReadings readings = readings_of(standing());
  readings.left.force.z() = 300, readings.right.force.z() = 0;
  readings.q[4] += 0.02;  // ankle pitch
  readings.q[3] += 0.03;  // knee
  return readings;
}

TEST(LegOdometry, FollowsTheWaistOfAWalkThatGoesAsPlanned) {
  const std::vector<Reference> walk =
      planned(walk_of({Straight{0.4, 0.1}, TangentArc{0.75, -0.6}, Stand{0.5}}));
  Isometry3d X_OP = Isometry3d::Identity();
  X_OP.translate(Vector3d(3, -2, 0)).rotate(Eigen::AngleAxisd(0.8, Vector3d::UnitZ()));
  LegOdometry legs(kRobot, X_OP * walk.front().X_PB);
  int changes = 0;
  Vector3d carrying = Vector3d::Constant(1e9);
  for (const Reference& reference : walk) {
    const SensorReadings readings = readings_of(reference);
    legs.add(readings);
    const auto [X_OB, p_OS] = legs.motion(readings.q);
    ASSERT_LT((X_OB.matrix() - (X_OP * reference.X_PB).matrix()).norm(), 1e-6) << "at " << reference.t_s;
    const Vector3d left = X_OP * reference.X_PL.translation(), right = X_OP * reference.X_PR.translation();
    ASSERT_LT(std::min((p_OS - left).norm(), (p_OS - right).norm()), 1e-6) << "at " << reference.t_s;
    changes += (p_OS - carrying).norm() > 0.01;
    carrying = p_OS;
  }
  EXPECT_GE(changes, 5) << "steps";
}

// Double support: the load shifts back and forth by less than a tenth.
TEST(LegOdometry, FeetThatShareTheLoadDoNotAlternate) {
  SensorReadings readings = readings_of(standing());
  LegOdometry legs(kRobot, Isometry3d::Identity());
  const auto sole = [&](double left, double right) {
    readings.left.force.z() = left, readings.right.force.z() = right;
    legs.add(readings);
    return legs.motion(readings.q).p_OS;
  };
  const Vector3d before = sole(300, 290);
  EXPECT_EQ(sole(300, 320), before);
  EXPECT_NEAR(sole(300, 340).y() - before.y(), -kRobot.foot_spacing, 1e-6);
}

// A foot that lands high and tilted does not move the waist at once; it settles until it lies flat on the
// floor.
TEST(LegOdometry, ASoleThatLandsSettlesOnTheFloor) {
  SensorReadings readings = before_a_high_landing();
  LegOdometry legs(kRobot, Isometry3d::Identity());
  legs.add(readings);
  readings.right.force.z() = 400;
  const Isometry3d before = legs.motion(readings.q).X_OB;
  legs.add(readings);
  // The bushing's deflection is smaller.
  EXPECT_LT((legs.motion(readings.q).X_OB.matrix() - before.matrix()).norm(), 1e-4);
  EXPECT_GT(legs.motion(readings.q).p_OS.z(), 0.002);
  for (int tick = 0; tick < 220; ++tick) {
    const Isometry3d last = legs.motion(readings.q).X_OB;
    legs.add(readings);
    EXPECT_LT((legs.motion(readings.q).X_OB.translation() - last.translation()).norm(), 0.002) << tick;
  }
  const auto [X_OB, p_OS] = legs.motion(readings.q);
  EXPECT_LT(std::abs(p_OS.z()), 1e-6);
  const Isometry3d X_OS = X_OB * measured_sole_in_base(kRobot, Side::right, readings.q.head<6>(),
                                                       deflections(kRobot.leg(Side::right), readings.right));
  EXPECT_LT((X_OS.linear() * Vector3d::UnitZ() - Vector3d::UnitZ()).norm(), 1e-6);
}

TEST(LegOdometry, RoundingErrorsDoNotGrowAtAnyHeading) {
  for (double heading = 0; heading < 6.3; heading += 0.1) {
    SensorReadings readings = before_a_high_landing();
    LegOdometry legs(kRobot, Isometry3d(Eigen::AngleAxisd(heading, Vector3d::UnitZ())));
    legs.add(readings);
    readings.right.force.z() = 400;
    for (int tick = 0; tick < 2000; ++tick) legs.add(readings);
    const Eigen::Matrix3d R_OB = legs.motion(readings.q).X_OB.linear();
    EXPECT_LT((R_OB * R_OB.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-13) << heading;
  }
}

TEST(LegOdometry, TheAnkleYieldsAccordingToItsStiffness) {
  LegVector q;
  q << 0.1, -0.05, -0.5, 0.9, -0.45, 0.08;
  const Vector3d ankle(0, 0, 0.105);
  const auto given_way = [&](const Vector3d& force, const Vector3d& about_ankle) {
    const Wrench wrench{force, about_ankle + ankle.cross(force)};
    return Isometry3d(
        sole_in_base(kRobot, Side::left, q).inverse() *
        measured_sole_in_base(kRobot, Side::left, q, deflections(kRobot.leg(Side::left), wrench)));
  };
  EXPECT_LT((given_way({0, 0, 478.036}, {0, 0, 0}).translation() - Vector3d(0, 0, 0.002)).norm(), 1e-12);
  const Isometry3d pitched = given_way({0, 0, 0}, {0, 5.02, 0});
  EXPECT_LT((pitched.linear() - Eigen::AngleAxisd(0.01, Vector3d::UnitY()).toRotationMatrix()).norm(), 1e-12);
  EXPECT_LT((pitched * ankle - ankle).norm(), 1e-12) << "about the ankle";
  EXPECT_LT((given_way({30, 20, 0}, {0, 0, 0}).matrix() - Isometry3d::Identity().matrix()).norm(), 1e-12)
      << "a force through the ankle causes no torque";
}

TEST(LegOdometry, ASoleTiltsOnItsPadsAboutItsMiddleAndBushAndPadsLag) {
  Leg leg;
  leg.sole_min << -0.1, -0.07;
  leg.sole_max << 0.14, 0.07;
  leg.pad_stiffness << 2000, 4000;
  const Vector3d force(0, 0, 500), middle(0.02, 0, 0);
  const auto tilt = [&](const Vector3d& about_middle) {
    return floor_under_sole(leg, {force, about_middle + middle.cross(force)});
  };
  EXPECT_LT((tilt({0, 0, 0}).matrix() - Isometry3d::Identity().matrix()).norm(), 1e-12);
  EXPECT_LT(
      (tilt({10, 0, 0}).linear() - Eigen::AngleAxisd(0.005, Vector3d::UnitX()).toRotationMatrix()).norm(),
      1e-12);
  EXPECT_LT((tilt({0, 10, 0}) * middle - middle).norm(), 1e-12);

  Robot soft = kRobot;
  soft.leg(Side::left).pad_stiffness << 2000, 4000;
  soft.leg(Side::left).pad_lag_s = 0.03;
  SensorReadings readings = readings_of(standing());
  readings.left.force.z() = 500;
  LegOdometry legs(soft, Isometry3d::Identity());
  legs.add(readings);
  const auto pitch = [&] { return legs.motion(readings.q).X_OB.linear()(0, 2); };
  const double before = pitch();
  readings.left.torque.y() += 8;
  legs.add(readings);
  const double bush = 8. / 502 * (1 - std::exp(-kPeriod * 502 / 5)),
               pads = 8. / 4000 * (1 - std::exp(-kPeriod / 0.03));
  EXPECT_NEAR(before - pitch(), bush + pads, 2e-5);
  for (int tick = 0; tick < 60; ++tick) legs.add(readings);
  EXPECT_NEAR(before - pitch(), 8. / 502 + 8. / 4000, 2e-5);
}

}  // namespace
}  // namespace walking
