#include "walking/kinematics.h"

#include <gmock/gmock.h>

#include <random>

#include "tests/walking/walks.h"
#include "walking/leg_odometry.h"

namespace walking {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kTenDecimals = 1e-10;  // the reference values are printed with ten decimals

Eigen::Isometry3d ankle_in_waist(Side side, const Vector6& q) {
  return sole_in_waist(side, q) * Eigen::Translation3d(0, 0, hrp2::kAnkleHeight);
}

/// Uniform within the limits, the knee bent enough to keep clear of the stretched leg's singularity, the sole
/// never pitched so far that the hip is below its plane.
Vector6 random_leg(Side side, std::mt19937_64& bits) {
  const LegLimits limits = leg_limits(side);
  Vector6 q;
  for (int i = 0; i < 6; ++i) {
    const double u = static_cast<double>(bits() >> 11) * 0x1p-53;
    const double lowest = i == 3 ? 0.05 : limits.lowest(i);
    q(i) = lowest + u * (limits.highest(i) - lowest);
  }
  const Eigen::Isometry3d X_AB = ankle_in_waist(side, q).inverse();
  const double hip_above_sole =
      (X_AB * Eigen::Vector3d(0, side == Side::left ? hrp2::kHipY : -hrp2::kHipY, 0)).z();
  return hip_above_sole > 2 * hrp2::kKneeY ? q : random_leg(side, bits);
}

TEST(Kinematics, ReferencePoseOfTheLeftLegIsTheReferenceOneForwardsAndBackwards) {
  const Vector6 q(.1, -.05, -.5, .9, -.45, .08);
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
  X_BA.translation() << .0260698066, .0706436577, -.5406679869;
  X_BA.linear() << .9935112935, -.1037621130, -.0465696631, .1021940891, .9941527387, -.0348812308,
      .0499167083, .0298957525, .9983058480;
  EXPECT_LT((ankle_in_waist(Side::left, q).matrix() - X_BA.matrix()).cwiseAbs().maxCoeff(), kTenDecimals);
  const LegSolution left = leg_inverse_kinematics(Side::left, X_BA);
  EXPECT_TRUE(left.reached);
  EXPECT_LT((left.q - q).cwiseAbs().maxCoeff(), 1e-8);  // ten decimals through the knee's slope
}

TEST(InverseKinematics, HalfSittingFeetGiveTheHalfSittingJointsWithTheAnkleWhereThePublishedRobotHasIt) {
  const BodySolution body = inverse_kinematics(standing());
  EXPECT_TRUE(body.left_reached && body.right_reached);
  EXPECT_LT((body.q - hrp2::half_sitting()).cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::Vector3d ankle = ankle_in_waist(Side::left, hrp2::half_sitting().segment<6>(6)).translation();
  EXPECT_LT((ankle - Eigen::Vector3d(.0094903511, .095, -.5437018512)).norm(), kTenDecimals);
  EXPECT_NEAR(hrp2::kAnkleX, ankle.x(), 1e-15);
  EXPECT_NEAR(hrp2::kWaistHeight, hrp2::kAnkleHeight - ankle.z(), 1e-15);
}

TEST(InverseKinematics, JointsOfThousandsOfPosesAreRecovered) {
  std::mt19937_64 bits(1);
  for (int i = 0; i < 8000; ++i) {
    const Side side = i % 2 == 0 ? Side::left : Side::right;
    const Vector6 q = random_leg(side, bits);
    const LegSolution leg = leg_inverse_kinematics(side, ankle_in_waist(side, q));
    ASSERT_TRUE(leg.reached) << q.transpose();
    // acos near a straight knee loses about eps / sin(0.05): 1e-12 leaves room for the chain's rounding.
    ASSERT_LT((leg.q - q).cwiseAbs().maxCoeff(), 1e-12) << q.transpose();
  }
}

TEST(InverseKinematics, LegTooShortIsReportedAndPointsAtTheFoot) {
  Posture posture = standing();
  posture.X_PL.translation() += Eigen::Vector3d(0.6, 0, -0.1);
  const BodySolution body = inverse_kinematics(posture);
  EXPECT_FALSE(body.left_reached);
  EXPECT_TRUE(body.right_reached);
  EXPECT_TRUE(body.q.allFinite());
  EXPECT_EQ(body.q(9), 0);  // stretched
  const Eigen::Vector3d hip(0, hrp2::kHipY, 0), ankle(0, 0, hrp2::kAnkleHeight);
  const Eigen::Vector3d wanted = posture.X_PB.inverse() * posture.X_PL * ankle - hip,
                        got = ankle_in_waist(Side::left, body.q.segment<6>(6)).translation() - hip;
  // The knee's offset is kept at the foot's true distance, the stretched leg is shorter: a degree.
  EXPECT_GT(got.normalized().dot(wanted.normalized()), std::cos(0.02));
}

TEST(InverseKinematics, HipBelowTheSoleAndFootInTheHipAreReportedAndFinite) {
  for (const double z : {0.4, 0.0}) {
    Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
    X_BA.translation() << 0, hrp2::kHipY, z;
    const LegSolution leg = leg_inverse_kinematics(Side::left, X_BA);
    EXPECT_FALSE(leg.reached) << z;
    EXPECT_TRUE(leg.q.allFinite()) << z;
  }
}

TEST(LegLimits, TheJointThatGoesTooFarOrTheFootOutOfReachIsNamed) {
  using testing::HasSubstr, testing::Optional;
  const BodySolution half_sitting{hrp2::half_sitting(), true, true};
  EXPECT_FALSE(leg_obstacle(half_sitting).has_value());
  BodySolution right = half_sitting, left = half_sitting;
  right.q(1) = -0.7;
  left.q(6) = -0.6;  // the left leg turns inwards 30 degrees at most
  EXPECT_THAT(leg_obstacle(right), Optional(HasSubstr("right hip roll")));
  EXPECT_THAT(leg_obstacle(left), Optional(HasSubstr("left hip yaw")));
  EXPECT_THAT(leg_obstacle({hrp2::half_sitting(), false, true}), Optional(HasSubstr("left foot")));
}

using Eigen::Isometry3d, Eigen::Vector3d;

/// The readings of a robot that does as planned; its ankles are loaded too little to yield.
SensorReadings readings_of(const Reference& reference) {
  SensorReadings readings;
  readings.q = inverse_kinematics(reference).q;
  readings.left.force.z() = reference.support == Support::right ? 0 : 1e-3;
  readings.right.force.z() = reference.support == Support::left ? 0 : 1e-3;
  return readings;
}

/// A robot on its left foot, the right one high and tilted.
SensorReadings before_a_high_landing() {
  SensorReadings readings = readings_of(standing());
  readings.left.force.z() = 300, readings.right.force.z() = 0;
  readings.q[hrp2::kRightLeg + 4] += 0.02;  // ankle pitch
  readings.q[hrp2::kRightLeg + 3] += 0.03;  // knee
  return readings;
}

TEST(LegOdometry, FollowsTheWaistOfAWalkThatGoesAsPlanned) {
  const std::vector<Reference> walk =
      planned(walk_of({Straight{0.4, 0.1}, TangentArc{0.75, -0.6}, Stand{0.5}}));
  Isometry3d X_OP = Isometry3d::Identity();
  X_OP.translate(Vector3d(3, -2, 0)).rotate(Eigen::AngleAxisd(0.8, Vector3d::UnitZ()));
  LegOdometry legs(X_OP * walk.front().X_PB);
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

// Double support: the load goes back and forth by less than a tenth.
TEST(LegOdometry, FeetThatShareTheLoadDoNotTakeTurns) {
  SensorReadings readings = readings_of(standing());
  LegOdometry legs(Isometry3d::Identity());
  const auto sole = [&](double left, double right) {
    readings.left.force.z() = left, readings.right.force.z() = right;
    legs.add(readings);
    return legs.motion(readings.q).p_OS;
  };
  const Vector3d before = sole(300, 290);
  EXPECT_EQ(sole(300, 320), before);
  EXPECT_NEAR(sole(300, 340).y() - before.y(), -hrp2::kFootSpacing, 1e-6);
}

// A foot that lands high and tilted does not move the waist at once, and comes to lie flat on the floor.
TEST(LegOdometry, ASoleThatLandsSettlesOnTheFloor) {
  SensorReadings readings = before_a_high_landing();
  LegOdometry legs(Isometry3d::Identity());
  legs.add(readings);
  readings.right.force.z() = 400;
  const Isometry3d before = legs.motion(readings.q).X_OB;
  legs.add(readings);
  EXPECT_LT((legs.motion(readings.q).X_OB.matrix() - before.matrix()).norm(), 1e-4);  // the bush's deflection
  EXPECT_GT(legs.motion(readings.q).p_OS.z(), 0.002);
  for (int tick = 0; tick < 220; ++tick) {
    const Isometry3d last = legs.motion(readings.q).X_OB;
    legs.add(readings);
    EXPECT_LT((legs.motion(readings.q).X_OB.translation() - last.translation()).norm(), 0.002) << tick;
  }
  const auto [X_OB, p_OS] = legs.motion(readings.q);
  EXPECT_LT(std::abs(p_OS.z()), 1e-6);
  const Isometry3d X_OS =
      X_OB * measured_sole_in_waist(Side::right, readings.q.segment<6>(hrp2::kRightLeg), readings.right);
  EXPECT_LT((X_OS.linear() * Vector3d::UnitZ() - Vector3d::UnitZ()).norm(), 1e-6);
}

TEST(LegOdometry, RoundingErrorsDoNotGrowWhateverTheHeading) {
  for (double heading = 0; heading < 6.3; heading += 0.1) {
    SensorReadings readings = before_a_high_landing();
    LegOdometry legs(Isometry3d(Eigen::AngleAxisd(heading, Vector3d::UnitZ())));
    legs.add(readings);
    readings.right.force.z() = 400;
    for (int tick = 0; tick < 2000; ++tick) legs.add(readings);
    const Eigen::Matrix3d R_OB = legs.motion(readings.q).X_OB.linear();
    EXPECT_LT((R_OB * R_OB.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-13) << heading;
  }
}

TEST(LegOdometry, TheAnkleGivesWayAsItsStiffnessSays) {
  Eigen::Matrix<double, 6, 1> q;
  q << 0.1, -0.05, -0.5, 0.9, -0.45, 0.08;
  const Vector3d ankle(0, 0, hrp2::kAnkleHeight);
  const auto given_way = [&](const Vector3d& force, const Vector3d& about_ankle) {
    const Wrench wrench{force, about_ankle + ankle.cross(force)};
    return Isometry3d(sole_in_waist(Side::left, q).inverse() * measured_sole_in_waist(Side::left, q, wrench));
  };
  EXPECT_LT((given_way({0, 0, 478.036}, {0, 0, 0}).translation() - Vector3d(0, 0, 0.002)).norm(), 1e-12);
  const Isometry3d pitched = given_way({0, 0, 0}, {0, 5.02, 0});
  EXPECT_LT((pitched.linear() - Eigen::AngleAxisd(0.01, Vector3d::UnitY()).toRotationMatrix()).norm(), 1e-12);
  EXPECT_LT((pitched * ankle - ankle).norm(), 1e-12) << "about the ankle";
  EXPECT_LT((given_way({30, 20, 0}, {0, 0, 0}).matrix() - Isometry3d::Identity().matrix()).norm(), 1e-12)
      << "a force through the ankle turns nothing";
}

}  // namespace
}  // namespace walking
