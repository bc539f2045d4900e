#include "walking/kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/walking/standing.h"
#include "walking/hrp2.h"

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

TEST(ForwardKinematics, ReferencePoseOfTheLeftLegIsTheReferenceOne) {
  const Eigen::Isometry3d X_BA = ankle_in_waist(Side::left, Vector6(.1, -.05, -.5, .9, -.45, .08));
  Eigen::Matrix3d R;
  R << .9935112935, -.1037621130, -.0465696631, .1021940891, .9941527387, -.0348812308, .0499167083,
      .0298957525, .9983058480;
  const Eigen::Vector3d p(.0260698066, .0706436577, -.5406679869);
  EXPECT_LT((X_BA.translation() - p).cwiseAbs().maxCoeff(), kTenDecimals);
  EXPECT_LT((X_BA.linear() - R).cwiseAbs().maxCoeff(), kTenDecimals);
}

TEST(InverseKinematics, ReferencePoseOfTheLeftLegIsRecovered) {
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
  X_BA.translation() << .0260698066, .0706436577, -.5406679869;
  X_BA.linear() << .9935112935, -.1037621130, -.0465696631, .1021940891, .9941527387, -.0348812308,
      .0499167083, .0298957525, .9983058480;
  const LegSolution left = leg_inverse_kinematics(Side::left, X_BA);
  const Vector6 expected(.1, -.05, -.5, .9, -.45, .08);
  EXPECT_TRUE(left.reached);
  EXPECT_LT((left.q - expected).cwiseAbs().maxCoeff(), 1e-8);  // ten decimals through the knee's slope
}

TEST(InverseKinematics, RightLegMirrorsTheLeft) {
  const Vector6 q(.1, -.05, -.5, .9, -.45, .08), mirrored(-.1, .05, -.5, .9, -.45, -.08);
  Eigen::Isometry3d X = ankle_in_waist(Side::left, q);
  const Eigen::DiagonalMatrix<double, 3> mirror(1, -1, 1);
  X.translation() = mirror * X.translation();
  X.linear() = mirror * X.linear() * mirror;
  EXPECT_LT((leg_inverse_kinematics(Side::right, X).q - mirrored).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(InverseKinematics, HalfSittingFeetGiveTheHalfSittingJoints) {
  const BodySolution body = inverse_kinematics(posture_of(standing()));
  EXPECT_TRUE(body.left_reached && body.right_reached);
  EXPECT_LT((body.q - hrp2::half_sitting()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(InverseKinematics, HalfSittingPutsTheAnkleWhereThePublishedRobotHasIt) {
  const Eigen::Isometry3d X = ankle_in_waist(Side::left, hrp2::half_sitting().segment<6>(6));
  EXPECT_NEAR(X.translation().x(), .0094903511, kTenDecimals);
  EXPECT_NEAR(X.translation().y(), .095, kTenDecimals);
  EXPECT_NEAR(X.translation().z(), -.5437018512, kTenDecimals);
  EXPECT_NEAR(hrp2::kAnkleX, X.translation().x(), 1e-15);
  EXPECT_NEAR(hrp2::kWaistHeight, hrp2::kAnkleHeight - X.translation().z(), 1e-15);
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
  Posture posture = posture_of(standing());
  posture.X_PL.translation() += Eigen::Vector3d(0.6, 0, -0.1);
  const BodySolution body = inverse_kinematics(posture);
  EXPECT_FALSE(body.left_reached);
  EXPECT_TRUE(body.right_reached);
  EXPECT_TRUE(body.q.allFinite());
  const Vector6 q = body.q.segment<6>(6);
  EXPECT_EQ(q(3), 0);  // stretched
  const Eigen::Vector3d hip(0, hrp2::kHipY, 0);
  const Eigen::Vector3d wanted =
      (posture.X_PB.inverse() * posture.X_PL * Eigen::Vector3d(0, 0, hrp2::kAnkleHeight) - hip).normalized();
  const Eigen::Vector3d got = (ankle_in_waist(Side::left, q).translation() - hip).normalized();
  // The knee's offset is kept at the foot's true distance, the stretched leg is shorter: a degree of
  // direction.
  EXPECT_GT(got.dot(wanted), std::cos(0.02));
}

TEST(InverseKinematics, HipBelowTheSoleIsReported) {
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
  X_BA.translation() << 0, hrp2::kHipY, 0.4;
  EXPECT_FALSE(leg_inverse_kinematics(Side::left, X_BA).reached);
}

TEST(InverseKinematics, FootInTheHipIsReportedAndFinite) {
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
  X_BA.translation() << 0, hrp2::kHipY, 0;
  const LegSolution leg = leg_inverse_kinematics(Side::left, X_BA);
  EXPECT_FALSE(leg.reached);
  EXPECT_TRUE(leg.q.allFinite());
}

TEST(LegLimits, HalfSittingIsWithinThem) {
  EXPECT_FALSE(leg_obstacle({hrp2::half_sitting(), true, true}).has_value());
}

TEST(LegLimits, TheJointThatGoesTooFarIsNamed) {
  BodySolution body{hrp2::half_sitting(), true, true};
  body.q(1) = -0.7;
  EXPECT_NE(leg_obstacle(body).value().find("right hip roll"), std::string::npos);
  body = {hrp2::half_sitting(), true, true};
  body.q(6) = -0.6;  // the left leg turns inwards 30 degrees at most
  EXPECT_NE(leg_obstacle(body).value().find("left hip yaw"), std::string::npos);
}

TEST(LegLimits, FootOutOfReachIsNamed) {
  EXPECT_NE(leg_obstacle({hrp2::half_sitting(), false, true}).value().find("left foot"), std::string::npos);
}

}  // namespace

}  // namespace walking
