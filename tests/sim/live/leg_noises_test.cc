#include "sim/live/leg_noises.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace sim::live {
namespace {

using testing::HasSubstr;

/// A camera that looks along x, walks 0.2 m/s ahead and sways by 30 mm to the side once a second. Leg
/// odometry has this relative error and overestimates the height by 2 mm. Every second frame on average,
/// its position is off by lost_m, and it slides by slid_m to the left or to the right.
LegNoises walk(double stride, double lost_m = 0, double slid_m = 0) {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d X_OC = X_WC;
  LegNoises noises;
  noises.start(X_WC, X_WC * Eigen::Translation3d(0.004, 0, 0));
  constexpr double kDt_s = 0.035;
  std::minstd_rand random;
  double slid = 0;
  for (int i = 0; i < 3000; ++i) {
    const double t = i * kDt_s, y = 0.03 * std::sin(2 * M_PI * t);
    X_WC.translation() << 0.2 * t, y, 1;
    slid += (random() % 1000 < 500 ? slid_m : -slid_m);
    const double lost = random() % 1000 < 500 ? lost_m : 0;
    X_OC.translation() << 0.2 * (1 + stride) * t + lost, y + slid, 1.002;
    noises.add(X_OC, X_WC, kDt_s);
  }
  noises.end(1);
  return noises;
}

TEST(LegNoises, ConstantErrorsOfTheStrideAreMeasuredOverTheWalk) {
  const std::string exact = walk(0).yaml(), wrong = walk(0.03).yaml();
  EXPECT_THAT(exact, HasSubstr("sigma_position_m: 0.0001, sigma_m_s: 0.003, sigma_stride: 0.003,"));
  EXPECT_THAT(exact, HasSubstr("sigma_position_m: 0.004,"));  // of the worst axis
  EXPECT_THAT(exact, HasSubstr("sigma_m: 0.0001, sigma_lasting_m: 0.002}"));
  EXPECT_THAT(wrong, HasSubstr("sigma_stride: 0.02"));  // along, but not across
}

TEST(LegNoises, ErrorsOfSingleFramesAndOfTwoWalksAreAdded) {
  LegNoises noises = walk(0);
  noises.add(walk(0, 0.001));
  // By 0.5 mm from their mean along one of three axes in one of two walks: 0.20 mm, and 0.1 mm of readings.
  EXPECT_THAT(noises.yaml(), HasSubstr("leg_odometry: {sigma_position_m: 0.00022, sigma_m_s: 0.003,"));
}

TEST(LegNoises, VelocitiesWithIndependentErrorsHaveNoErrorsOfSwayButOfPositionWithinAStride) {
  // 0.35 mm in 35 ms along one of three axes: 10 mm/s / √3. They add up to 0.35 mm √(1 s / 70 ms) within a
  // stride, which is the same over 8 frames: × √8 / √3.
  EXPECT_THAT(
      walk(0, 0, 0.00035).yaml(),
      HasSubstr("sigma_position_m: 0.002, sigma_m_s: 0.0057, sigma_stride: 0.003, sigma_sway_m_s: 0.003,"));
}

}  // namespace
}  // namespace sim::live
