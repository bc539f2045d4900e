// The planned velocity's own error.
#include "sim/sensor_errors/plan_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sim::sensor_errors {
namespace {

slam::Stamp plan_time(int k) { return slam::Stamp(k * 33'333'333LL); }

// What the plan's position says of the velocity, for a robot that stands.
std::vector<Eigen::Vector3d> velocities(PlanErrors errors, int frames) {
  std::vector<Eigen::Vector3d> all;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (int k = 0; k < frames; ++k) {
    const Eigen::Vector3d p = errors.apply(slam::PlannedMotion{}, plan_time(k))->X_PC.translation();
    if (k > 0) all.push_back((p - before) / slam::seconds(plan_time(k) - plan_time(k - 1)));
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
  EXPECT_EQ(square.z(), 0);  // what the plan says of the height stays
}

TEST(PlanVelocityError, OfZeroChangesNoBit) {
  PlanErrors none(0, 1, {});
  slam::PlannedMotion plan;
  plan.X_PC.translation() << 0.1, 0.2, 0.3;
  EXPECT_EQ(none.apply(plan, plan_time(1))->X_PC.matrix(), plan.X_PC.matrix());
}

TEST(PlanVelocityError, IsTheSameForTheSameSeedAndStamp) {
  EXPECT_EQ(velocities(PlanErrors(0.05, 3, {}), 9), velocities(PlanErrors(0.05, 3, {}), 9));
  EXPECT_NE(velocities(PlanErrors(0.05, 3, {}), 9), velocities(PlanErrors(0.05, 4, {}), 9));
}

}  // namespace
}  // namespace sim::sensor_errors
