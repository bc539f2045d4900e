#include "walking/arms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/walking/smooth_walk.h"
#include "tests/walking/standing.h"
#include "walking/hrp2.h"
#include "walking/kinematics.h"
#include "walking/pattern_generator.h"

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

// A waist with a flywheel's inertia, and arms of known momentum about the vertical.
constexpr double kTrunk = 1.5, kRightArm = -0.4, kLeftArm = 0.4;  // kg m²

BodyMomentum flywheel(const BodyMotion& motion) {
  BodyMomentum momentum;
  momentum.mass = 50;
  momentum.angular.z() =
      kTrunk * motion.w.z() + kRightArm * motion.dq(hrp2::kRightArm) + kLeftArm * motion.dq(hrp2::kLeftArm);
  return momentum;
}

Reference turned(double yaw) {
  return moved(Eigen::Isometry3d(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), standing());
}

double shoulder(const ArmAngles& arm) { return arm.shoulder_pitch - ArmAngles{}.shoulder_pitch; }

TEST(ArmMomentum, StandingRobotKeepsHalfSitting) {
  ArmMomentum arms(flywheel);
  for (int k = 0; k < 100; ++k) {
    const Arms now = arms(turned(0.3));
    ASSERT_NEAR(shoulder(now.right), 0, 1e-14);  // rounding of the waist's turn
    ASSERT_NEAR(shoulder(now.left), 0, 1e-14);
  }
}

TEST(ArmMomentum, ArmsCompensateATurnInEqualParts) {
  ArmMomentum arms(flywheel);
  arms(turned(0));
  const double turn = 0.001;
  const Arms now = arms(turned(turn));
  // 2 (0.4 kg m²) swung = 1.5 kg m² turned.
  EXPECT_NEAR(shoulder(now.right), kTrunk * turn / 0.8, 1e-12);
  EXPECT_NEAR(shoulder(now.left), -kTrunk * turn / 0.8, 1e-12);
}

TEST(ArmMomentum, OfAnAlternatingTurnLittleIsLeft) {
  ArmMomentum arms(flywheel);
  double alone = 0, together = 0;
  const double omega = 2 * std::numbers::pi / 0.8;  // a step
  Arms before = arms(turned(0));
  for (int k = 1; k <= 1600; ++k) {
    const double yaw = 0.05 * std::sin(omega * k * kPeriod),
                 last = 0.05 * std::sin(omega * (k - 1) * kPeriod);
    const Arms now = arms(turned(yaw));
    const double trunk = kTrunk * (yaw - last) / kPeriod;
    const double swung = (shoulder(now.right) - shoulder(before.right)) / kPeriod * kRightArm +
                         (shoulder(now.left) - shoulder(before.left)) / kPeriod * kLeftArm;
    before = now;
    if (k <= 800) continue;  // the start has died away, exp(-4 s / 0.5 s)
    alone += trunk * trunk;
    together += (trunk + swung) * (trunk + swung);
  }
  // A first-order low pass of 0.5 s at 7.85 rad/s leaves 0.247.
  EXPECT_NEAR(std::sqrt(together / alone), 1 / std::hypot(1.0, 0.5 * omega), 0.005);  // backward differences
}

TEST(ArmMomentum, ArmsSettleInASteadyTurnAndNeverGoTooFar) {
  for (const double rate : {0.1, 3.0}) {
    ArmMomentum arms(flywheel);
    Arms now;
    for (int k = 0; k < 2000; ++k) now = arms(turned(rate * k * kPeriod));
    // 0.5 s of the turn's momentum, shared by two arms of 0.4 kg m².
    EXPECT_NEAR(shoulder(now.right), std::min(0.7, 0.5 * rate * kTrunk / 0.8), 1e-3);
    EXPECT_NEAR(shoulder(now.left), -shoulder(now.right), 1e-12);
  }
}

TEST(ArmMomentum, PlanHasItsArmsAndNothingElseChanges) {
  WalkOptions options;
  options.commands = {TangentArc{0.75, 0.4}};
  PatternGenerator still(options, flywheel);
  options.arm_motion = ArmMotion::momentum;
  PatternGenerator moving(options, flywheel);
  double furthest = 0;
  for (std::size_t k = 0; k < still.ticks(); ++k) {
    const Reference a = still.next(), b = moving.next();
    ASSERT_TRUE(a.X_PB.matrix() == b.X_PB.matrix());
    ASSERT_TRUE(a.X_PL.matrix() == b.X_PL.matrix());
    furthest = std::max(furthest, std::abs(shoulder(b.arms.left)));
    ASSERT_EQ(shoulder(a.arms.left), 0);
  }
  EXPECT_GT(furthest, 0.05);
}

}  // namespace

}  // namespace walking
