#include <gtest/gtest.h>

#include <cmath>

#include "tests/walking/smooth_walk.h"
#include "tests/walking/standing.h"
#include "walking/arms.h"
#include "walking/hrp2.h"
#include "walking/kinematics.h"

namespace walking {
namespace {

constexpr double kFiveDecimals = 5e-6;  // degrees, five decimals

TEST(ArmSwing, AnglesAreTheReferenceOnes) {
  const ArmAngles forward = arm_swing(.15), middle = arm_swing(0), back = arm_swing(-.15);
  EXPECT_NEAR(forward.elbow / kDegree, -28.92161, kFiveDecimals);
  EXPECT_NEAR(forward.shoulder_pitch / kDegree, 18.48963, kFiveDecimals);
  EXPECT_NEAR(middle.elbow / kDegree, -30, 1e-12);
  EXPECT_NEAR(middle.shoulder_pitch / kDegree, 15, 1e-12);
  EXPECT_NEAR(back.elbow / kDegree, -28.92161, kFiveDecimals);
  EXPECT_NEAR(back.shoulder_pitch / kDegree, 10.43198, kFiveDecimals);
}

TEST(ArmSwing, HandGoesAgainstTheFootAtItsHeight) {
  for (const double foot : {-0.3, -0.1, 0.05, 0.15, 0.4}) {
    const ArmAngles arm = arm_swing(foot);
    // Shoulder and elbow turn about y: positive pitch brings the hand back.
    const double x = -0.25 * std::sin(arm.shoulder_pitch) - 0.25 * std::sin(arm.shoulder_pitch + arm.elbow);
    const double z = -0.25 * std::cos(arm.shoulder_pitch) - 0.25 * std::cos(arm.shoulder_pitch + arm.elbow);
    EXPECT_NEAR(x, -0.2267747 * foot, 1e-7);
    EXPECT_NEAR(z, -0.4829629, 1e-7);
  }
}

JointVector swinging(Reference reference) {
  reference.arms = arm_swing(reference);
  return inverse_kinematics(posture_of(reference)).q;
}

TEST(ArmSwing, StandingRobotKeepsHalfSitting) {
  EXPECT_LT((swinging(standing()) - hrp2::half_sitting()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ArmSwing, EachArmFollowsTheFootOnItsSideInTheWaistsAxes) {
  Reference stride = standing();
  stride.X_PL.translation().x() += 0.15;
  stride.X_PR.translation().x() -= 0.15;
  stride =
      moved(Eigen::Isometry3d(Eigen::Translation3d(3, 1, 0) * Eigen::AngleAxisd(2, Eigen::Vector3d::UnitZ())),
            stride);
  const JointVector still = inverse_kinematics(posture_of(stride)).q, swung = swinging(stride);
  EXPECT_NEAR(swung(23) / kDegree, 18.48963, kFiveDecimals);  // left shoulder
  EXPECT_NEAR(swung(16) / kDegree, 10.43198, kFiveDecimals);  // right shoulder
  EXPECT_NEAR(swung(26) / kDegree, -28.92161, kFiveDecimals);
  EXPECT_NEAR(swung(19) / kDegree, -28.92161, kFiveDecimals);
  JointVector difference = swung - still;
  for (const int joint : {16, 19, 23, 26}) difference(joint) = 0;
  EXPECT_TRUE(difference.isZero(0));
}

}  // namespace
}  // namespace walking
