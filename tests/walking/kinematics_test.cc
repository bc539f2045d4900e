#include "walking/kinematics.h"

#include <gmock/gmock.h>

#include <random>

#include "tests/walking/walks.h"

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
  const BodySolution body = inverse_kinematics(posture_of(standing()));
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
  Posture posture = posture_of(standing());
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

}  // namespace
}  // namespace walking
