#include "slam/motion_model.h"

#include <gtest/gtest.h>

namespace slam {
namespace {

Eigen::Isometry3d pose() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 2) / 3).matrix();
  X.translation() = Eigen::Vector3d(1, 2, 3);
  return X;
}

TEST(InitialState, IsAtRestAtTheGivenPose) {
  const RobotVector x = initial_state(pose(), Options{}).x;
  EXPECT_EQ(x.head<3>(), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((rotation_matrix(x.segment<4>(kOrientation)) - pose().linear()).norm(), 1e-15);
  EXPECT_EQ(x.tail<kRobot - kVelocity>().norm(), 0);
}

TEST(InitialState, HasTheStandardDeviationsOfTheOptions) {
  Options options;
  options.start = {0.1, 0.2, 0.3, 0.4};
  options.gyro.sigma_bias_rad_s = 0.5;
  options.accelerometer.sigma_bias_m_s2 = 0.6;
  options.plan_velocity.sigma_slip_m_s = 0.7;
  options.plan_velocity.sigma_stride = 0.8;
  const RobotVector sigma = initial_state(pose(), options).P.diagonal().cwiseSqrt();
  for (const auto& [at, expected] : {std::pair{kPosition, 0.1},
                                     {kVelocity, 0.3},
                                     {kRate, 0.4},
                                     {kGyroBias, 0.5},
                                     {kAccelerometerBias, 0.6},
                                     {kSlip, 0.7},
                                     {kStrideError, 0.8},
                                     {kSwayVelocity, options.plan_velocity.sigma_sway_m_s}})
    EXPECT_NEAR(sigma(at), expected, 1e-15) << at;
  const double omega = 2 * 3.14159265358979 / options.plan_velocity.sway_period_s;
  EXPECT_NEAR(sigma(kSwayPosition), options.plan_velocity.sigma_sway_m_s / omega, 1e-15);
}

TEST(InitialState, TheOrientationVariesByRotationsOnly) {
  Options options;
  options.start.sigma_orientation_rad = 0.2;
  const RobotState initial = initial_state(pose(), options);
  const Eigen::Vector4d q = initial.x.segment<4>(kOrientation);
  const Eigen::Matrix4d P = initial.P.block<4, 4>(kOrientation, kOrientation);
  EXPECT_LT((P * q).norm(), 1e-16);
  EXPECT_NEAR(P.trace(), 3 * 0.2 * 0.2 / 4, 1e-15);  // |∂q/∂θ| = 1/2 about each axis
}

}  // namespace
}  // namespace slam
