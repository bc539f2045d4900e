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

// Velocities from the planned positions of a standing robot.
std::vector<Eigen::Vector3d> velocities(PlanErrors errors, int frames) {
  std::vector<Eigen::Vector3d> all;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (int k = 0; k < frames; ++k) {
    const Eigen::Vector3d p = errors.apply(slam::PlannedMotion{}, frame(k))->X_PC.translation();
    if (k > 0) all.push_back((p - before) / slam::seconds(frame(k) - frame(k - 1)));
    before = p;
  }
  return all;
}

TEST(PlanVelocityError, IsWhiteAndOfThatSizeAlongXAndY) {
  const auto all = velocities(PlanErrors(0.05, 1, {}), 4001);
  Eigen::Vector3d square = Eigen::Vector3d::Zero(), neighbours = square;
  for (std::size_t k = 0; k < all.size(); ++k) {
    square += all[k].cwiseAbs2() / 4000;
    if (k > 0) neighbours += all[k].cwiseProduct(all[k - 1]) / 4000;
  }
  // Four standard deviations of a variance and of a correlation of 4000 numbers.
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(square(axis), 0.0025, 4 * 0.0025 * std::sqrt(2 / 4000.0));
    EXPECT_NEAR(neighbours(axis), 0, 4 * 0.0025 / std::sqrt(4000.0));
  }
  EXPECT_EQ(square.z(), 0);  // the planned height stays
}

TEST(PlanVelocityError, OfZeroChangesNoBit) {
  PlanErrors none(0, 1, {});
  slam::PlannedMotion plan;
  plan.X_PC.translation() << 0.1, 0.2, 0.3;
  EXPECT_EQ(none.apply(plan, frame(1))->X_PC.matrix(), plan.X_PC.matrix());
}

TEST(PlanVelocityError, IsTheSameForTheSameSeedAndStamp) {
  EXPECT_EQ(velocities(PlanErrors(0.05, 3, {}), 9), velocities(PlanErrors(0.05, 3, {}), 9));
  EXPECT_NE(velocities(PlanErrors(0.05, 3, {}), 9), velocities(PlanErrors(0.05, 4, {}), 9));
}

}  // namespace
}  // namespace sim::sensor_errors
