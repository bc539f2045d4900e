#include "sim/sensor_errors/leg_errors.h"

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

TEST(LegErrors, TheNoiseOfThePositionIsWhiteAndOfThatSize) {
  LegErrors errors(1e-4, 0, 1);
  Eigen::Vector3d square = Eigen::Vector3d::Zero(), neighbours = square, before = square;
  for (int k = 0; k < 4000; ++k) {
    const Eigen::Vector3d error = position(errors, k) - Eigen::Vector3d(5 + 0.01 * k, 0, 0);
    square += error.cwiseAbs2() / 4000;
    neighbours += error.cwiseProduct(before) / 4000;
    before = error;
  }
  // Four standard deviations of a variance and of a correlation of 4000 numbers.
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(square(axis), 1e-8, 4e-8 * std::sqrt(2 / 4000.0));
    EXPECT_NEAR(neighbours(axis), 0, 4e-8 / std::sqrt(4000.0));
  }
}

TEST(LegErrors, TheNoiseIsThatOfSeedAndStamp) {
  LegErrors one(1e-4, 0, 1), same(1e-4, 0, 1), other(1e-4, 0, 2);
  position(same, 3);
  EXPECT_EQ(position(one, 7), position(same, 7));
  EXPECT_NE(position(one, 7), position(other, 7));
}

TEST(LegErrors, DistancesFromTheFirstPositionOnAreScaled) {
  LegErrors errors(0, 0.2, 1);
  EXPECT_EQ(position(errors, 0).x(), 5);
  EXPECT_NEAR(position(errors, 50).x(), 5.6, 1e-12);
}

TEST(LegErrors, OfZeroChangeNoBit) {
  LegErrors none(0, 0, 1);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(position(none, k), Eigen::Vector3d(5 + 0.01 * k, 0, 0));
}

}  // namespace
}  // namespace sim::sensor_errors
