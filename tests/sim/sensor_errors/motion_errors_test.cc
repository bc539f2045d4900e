#include "sim/sensor_errors/motion_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sim::sensor_errors {
namespace {

slam::Stamp frame(int k) { return slam::Stamp(k * 33'333'333LL); }

/// The position of a camera that moves 0.01 m a frame along x, from 5 m on.
Eigen::Vector3d position(LegErrors& errors, int k) {
  slam::LegMotion legs;
  legs.X_OC.translation().x() = 5 + 0.01 * k;
  errors.apply(legs, frame(k));
  return legs.X_OC.translation();
}

// Variance and correlation within four standard deviations of those of so many numbers.
TEST(LegErrors, TheNoiseOfThePositionIsWhiteOfThatSizeAndOfSeedAndStamp) {
  constexpr double n = 4000, variance = 1e-8;
  LegErrors errors(1e-4, 0, 1);
  Eigen::Array3d square = Eigen::Array3d::Zero(), neighbors = square, before = square;
  for (int k = 0; k < n; ++k) {
    const Eigen::Array3d error = position(errors, k) - Eigen::Vector3d(5 + 0.01 * k, 0, 0);
    square += error.square() / n;
    neighbors += error * std::exchange(before, error) / n;
  }
  EXPECT_TRUE(((square - variance).abs() < 4 * variance * std::sqrt(2 / n)).all()) << square.transpose();
  EXPECT_TRUE((neighbors.abs() < 4 * variance / std::sqrt(n)).all()) << neighbors.transpose();
  LegErrors one(1e-4, 0, 1), same(1e-4, 0, 1), other(1e-4, 0, 2);
  position(same, 3);
  EXPECT_EQ(position(one, 7), position(same, 7));
  EXPECT_NE(position(one, 7), position(other, 7));
}

TEST(LegErrors, DistancesFromTheFirstPositionOnAreScaledAndErrorsOfZeroChangeNoBit) {
  LegErrors errors(0, 0.2, 1), none(0, 0, 1);
  EXPECT_EQ(position(errors, 0).x(), 5);
  EXPECT_NEAR(position(errors, 50).x(), 5.6, 1e-12);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(position(none, k), Eigen::Vector3d(5 + 0.01 * k, 0, 0));
}

}  // namespace
}  // namespace sim::sensor_errors
