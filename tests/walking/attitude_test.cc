#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "walking/plan.h"
#include "walking/stabilizer.h"

namespace walking {
namespace {

using Eigen::Vector3d;

const Vector3d kUp = Vector3d::UnitZ(), kStill = Vector3d::Zero();

double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

TEST(Attitude, StaysWhereItIsAtRest) {
  Attitude attitude(kUp);
  for (int k = 0; k < 1000; ++k) attitude.update(kStill, kGravity * kUp, kStill, kPeriod);
  EXPECT_EQ(attitude.up(), kUp);
}

TEST(Attitude, FollowsATurnByTheGyro) {
  Attitude attitude(kUp);
  const Vector3d rate(0.6, -0.3, 0.8);
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (int k = 0; k < 100; ++k) {
    R = R * Eigen::AngleAxisd(rate.norm() * kPeriod, rate.normalized());
    attitude.update(rate, R.transpose() * (kGravity * kUp), kStill, kPeriod);
  }
  // The correction sees the vertical one tick ahead of the gyro's: 4e-3 rad of it, times gain 0.15/s, over
  // 0.5 s.
  EXPECT_LT(angle_between(attitude.up(), R.transpose() * kUp), 5e-4);
  EXPECT_GT(angle_between(attitude.up(), kUp), 0.2);
}

TEST(Attitude, FindsTheVerticalAtTheRateOfItsGain) {
  AttitudeOptions options;
  options.bias_gain_per_s2 = 0;
  const double wrong = 0.05;
  Attitude attitude(Vector3d(std::sin(wrong), 0, std::cos(wrong)), options);
  const int ticks = static_cast<int>(1 / options.accelerometer_gain_per_s / kPeriod);
  for (int k = 0; k < ticks; ++k) attitude.update(kStill, kGravity * kUp, kStill, kPeriod);
  // The decay is of the sine of the error: at 0.05 rad within 1e-3 of an exponential.
  EXPECT_NEAR(angle_between(attitude.up(), kUp), wrong * std::exp(-1), 1e-3 * wrong);
}

TEST(Attitude, LearnsAConstantBiasOfTheGyroButNotAboutTheVertical) {
  Attitude attitude(kUp);
  const Vector3d bias(0.01, -0.005, 0.02);
  for (int k = 0; k < 60000; ++k) attitude.update(bias, kGravity * kUp, kStill, kPeriod);  // 300 s
  EXPECT_LT((attitude.bias() - Vector3d(bias.x(), bias.y(), 0)).norm(), 1e-4);
  EXPECT_LT(angle_between(attitude.up(), kUp), 1e-3);
}

TEST(Attitude, IsNotTiltedByAnAccelerationItIsGiven) {
  Attitude with_motion(kUp), without_motion(kUp);
  const Vector3d acceleration(1.0, 0.5, 0);
  for (int k = 0; k < 200; ++k) {
    with_motion.update(kStill, kGravity * kUp + acceleration, acceleration, kPeriod);
    without_motion.update(kStill, kGravity * kUp + acceleration, kStill, kPeriod);
  }
  EXPECT_LT(angle_between(with_motion.up(), kUp), 1e-12);
  EXPECT_GT(angle_between(without_motion.up(), kUp), 0.01);
}

}  // namespace
}  // namespace walking
