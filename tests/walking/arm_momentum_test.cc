#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/walking/standing.h"
#include "walking/arms.h"
#include "walking/hrp2.h"
#include "walking/pattern_generator.h"

namespace walking {
namespace {

// A waist with a flywheel's inertia, and arms whose momentum about the vertical is known.
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
