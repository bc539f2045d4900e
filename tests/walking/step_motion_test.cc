#include "walking/step_motion.h"

#include "tests/walking/walks.h"
#include "walking/kinematics.h"

namespace walking {
namespace {

constexpr double kSingleSupport = 0.78, kStride = 0.30, kHeight = 0.07;

Eigen::Vector3d at(double t, SwingPolynomial polynomial = SwingPolynomial::quintic) {
  return swing_foot({}, {{kStride, 0}, 0}, t / kSingleSupport, kHeight, polynomial).translation();
}

TEST(SwingFoot, QuinticIsTheReferenceOne) {
  const double rows[][3] = {{.1, .001720697, .013991280},
                            {.2, .024882097, .040715108},
                            {.39, .15, .07},
                            {.6, .282426446, .035292882}};
  for (const auto& [t, x, z] : rows)
    EXPECT_LT((at(t) - Eigen::Vector3d(x, 0, z)).norm(), 7.1e-10) << "at " << t;  // nine decimals each
  double along = 0, up = 0;
  constexpr double h = 1e-4;
  for (double t = 0; t < kSingleSupport - h; t += h) {
    const Eigen::Vector3d velocity = (at(t + h) - at(t)) / h;
    along = std::max(along, velocity.x());
    up = std::max(up, velocity.z());
  }
  EXPECT_NEAR(along, .801, 5e-4);  // three decimals
  EXPECT_NEAR(up, .276, 5e-4);
}

TEST(SwingFoot, LeavesAndMeetsTheGroundVertically) {
  for (const auto polynomial : {SwingPolynomial::quintic, SwingPolynomial::cubic}) {
    EXPECT_EQ(at(0.04 * kSingleSupport, polynomial).x(), 0);
    EXPECT_NEAR(at(0.96 * kSingleSupport, polynomial).x(), kStride, 1e-15);
    EXPECT_EQ(at(0, polynomial).z(), 0);
    EXPECT_EQ(at(kSingleSupport, polynomial).z(), 0);
  }
  const double s = (.2 / kSingleSupport - .05) / .9;
  EXPECT_NEAR(at(.2, SwingPolynomial::cubic).x(), kStride * (3 * s * s - 2 * s * s * s), 1e-15);
}

TEST(SwingFoot, GoesExactlyFromPlaceToPlaceAndTurnsAboutTheVerticalOnly) {
  const FootPose from{{0.3, -0.2}, 0.4}, to{{0.55, -0.13}, 0.9};
  const auto X = [&](double s) { return swing_foot(from, to, s, kHeight, SwingPolynomial::quintic); };
  EXPECT_TRUE(X(0).isApprox(sole(from), 1e-15));
  EXPECT_TRUE(X(1).isApprox(sole(to), 1e-15));
  EXPECT_NEAR(yaw_of(X(0.5)), 0.65, 1e-15);
  EXPECT_EQ(X(0.5).linear().col(2), Eigen::Vector3d::UnitZ());
}

TEST(WaistYaw, IsACubicWithItsOwnDerivativeAsRate) {
  Phase phase;
  phase.ticks = 156;
  phase.waist_yaw_from = 0.5;
  phase.waist_yaw_to = 0.7;
  for (const auto& [s, yaw] : {std::pair(0.0, 0.5), {0.5, 0.6}, {1.0, 0.7}})
    EXPECT_NEAR(waist_yaw(phase, s).yaw, yaw, 1e-15);
  EXPECT_EQ(waist_yaw(phase, 0).rate, 0);
  EXPECT_EQ(waist_yaw(phase, 1).rate, 0);
  constexpr double h = 1e-5;
  for (const double s : {0.1, 0.4, 0.8}) {
    const double change = waist_yaw(phase, s + h).yaw - waist_yaw(phase, s - h).yaw;
    EXPECT_NEAR(waist_yaw(phase, s).rate, change / (2 * h * kSingleSupport), 1e-9);  // h² and eps / h
  }
}

constexpr double kFiveDecimals = 5e-6;  // degrees, five decimals

TEST(ArmSwing, HandGoesAgainstTheFootAtItsHeight) {
  for (const double foot : {-0.3, -0.1, 0.0, 0.05, 0.15, 0.4}) {
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

TEST(ArmSwing, EachArmFollowsTheFootOnItsSideInTheWaistsAxesByTheReferenceAngles) {
  Reference stride = standing();
  stride.X_PL.translation().x() += 0.15;
  stride.X_PR.translation().x() -= 0.15;
  const Eigen::Isometry3d X(Eigen::Translation3d(3, 1, 0) * Eigen::AngleAxisd(2, Eigen::Vector3d::UnitZ()));
  for (auto* pose : {&stride.X_PB, &stride.X_PL, &stride.X_PR}) *pose = X * *pose;
  const JointVector swung = swinging(stride);
  EXPECT_NEAR(swung(23) / kDegree, 18.48963, kFiveDecimals);  // left shoulder
  EXPECT_NEAR(swung(16) / kDegree, 10.43198, kFiveDecimals);  // right shoulder
  EXPECT_NEAR(swung(26) / kDegree, -28.92161, kFiveDecimals);
  EXPECT_NEAR(swung(19) / kDegree, -28.92161, kFiveDecimals);
  JointVector difference = swung - inverse_kinematics(posture_of(stride)).q;
  for (const int joint : {16, 19, 23, 26}) difference(joint) = 0;
  EXPECT_TRUE(difference.isZero(0));
}

}  // namespace
}  // namespace walking
