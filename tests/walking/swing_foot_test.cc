#include "walking/swing_foot.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/walking/smooth_walk.h"

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
  for (const auto& [t, x, z] : rows) {
    EXPECT_NEAR(at(t).x(), x, 5e-10) << "at " << t;  // nine decimals
    EXPECT_NEAR(at(t).z(), z, 5e-10) << "at " << t;
  }
}

TEST(SwingFoot, PeakSpeedsAreTheReferenceOnes) {
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

TEST(SwingFoot, CubicLeavesEarlierAndPeaksSlower) {
  EXPECT_GT(at(.1, SwingPolynomial::cubic).x(), at(.1).x());
  EXPECT_NEAR(at(.39, SwingPolynomial::cubic).x(), .15, 1e-15);
  const double s = (.2 / kSingleSupport - .05) / .9;
  EXPECT_NEAR(at(.2, SwingPolynomial::cubic).x(), kStride * (3 * s * s - 2 * s * s * s), 1e-15);
}

TEST(SwingFoot, LeavesAndMeetsTheGroundVertically) {
  for (const auto polynomial : {SwingPolynomial::quintic, SwingPolynomial::cubic}) {
    EXPECT_EQ(at(0.04 * kSingleSupport, polynomial).x(), 0);
    EXPECT_NEAR(at(0.96 * kSingleSupport, polynomial).x(), kStride, 1e-15);
    EXPECT_EQ(at(0, polynomial).z(), 0);
    EXPECT_EQ(at(kSingleSupport, polynomial).z(), 0);
  }
}

TEST(SwingFoot, StartsAndEndsExactlyAtItsPlaces) {
  const FootPose from{{0.3, -0.2}, 0.4}, to{{0.55, -0.13}, 0.9};
  EXPECT_TRUE(swing_foot(from, to, 0, kHeight, SwingPolynomial::quintic).isApprox(sole(from), 1e-15));
  EXPECT_TRUE(swing_foot(from, to, 1, kHeight, SwingPolynomial::quintic).isApprox(sole(to), 1e-15));
}

TEST(SwingFoot, TurnsAboutTheVerticalOnly) {
  const FootPose from{{0, 0}, -0.1}, to{{0.2, 0}, 0.3};
  const auto X = swing_foot(from, to, 0.5, kHeight, SwingPolynomial::quintic);
  EXPECT_NEAR(yaw_of(X), 0.1, 1e-15);
  EXPECT_EQ(X.linear().col(2), Eigen::Vector3d::UnitZ());
}

TEST(WaistYaw, IsACubicWithItsOwnDerivativeAsRate) {
  Phase phase;
  phase.ticks = 156;
  phase.waist_yaw_from = 0.5;
  phase.waist_yaw_to = 0.7;
  EXPECT_EQ(waist_yaw(phase, 0).yaw, 0.5);
  EXPECT_NEAR(waist_yaw(phase, 0.5).yaw, 0.6, 1e-15);
  EXPECT_NEAR(waist_yaw(phase, 1).yaw, 0.7, 1e-15);
  EXPECT_EQ(waist_yaw(phase, 0).rate, 0);
  EXPECT_EQ(waist_yaw(phase, 1).rate, 0);
  constexpr double h = 1e-5;
  for (const double s : {0.1, 0.4, 0.8}) {
    const double slope =
        (waist_yaw(phase, s + h).yaw - waist_yaw(phase, s - h).yaw) / (2 * h * kSingleSupport);
    EXPECT_NEAR(waist_yaw(phase, s).rate, slope, 1e-9);  // central difference: h² and eps / h
  }
  const double acceleration = waist_yaw(phase, h).rate / (h * kSingleSupport);
  EXPECT_NEAR(acceleration, 1.97, 5e-3);  // the cubic's jump at lift-off for 0.2 rad
}

}  // namespace
}  // namespace walking
