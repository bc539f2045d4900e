#include "slam/motion_model.h"

#include <gtest/gtest.h>

#include "tests/numerical_jacobian.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

constexpr double kFrame = 1.0 / 30;

RobotVector reference_state() {
  RobotVector x = RobotVector::Zero();
  x.head<13>() << .1, -.2, 1.3, .9233805169, .1025978352, -.2051956704, .3077935056, .2, -.1, .05, .3, -.4,
      .5;
  return x;
}

Options paper() {
  Options options;
  options.motion = {4, 6};
  options.plan_velocity.sigma_sway_m_s = options.plan_velocity.sigma_stride = 0;
  options.accelerometer.sigma_bias_walk_m_s3 = 0;
  return options;
}

TEST(MotionModel, MovesTheReferenceStateAsPublished) {
  const Prediction p = predict_motion(reference_state(), kFrame, std::nullopt, paper());
  Eigen::Matrix<double, 7, 1> expected;
  expected << .1066666667, -.2033333333, 1.3016666667, .9188705907, .107549491, -.2106531788, .3158087757;
  EXPECT_NEAR((p.x.head<7>() - expected).norm(), 0, 2e-10);  // digits of the reference
  EXPECT_EQ((p.x.segment<6>(kVelocity)), (reference_state().segment<6>(kVelocity)));
}

TEST(MotionModel, VelocityAndRateAfterwardsAreTheMeansOverTheInterval) {
  const RobotVector x = reference_state();
  const RobotVector y =
      predict_motion(x, kFrame, VelocityIncrement{{0.1, 0.2, 0.3}, kFrame, 0.01}, paper()).x;
  const Eigen::Vector3d moved = y.segment<3>(kPosition) - x.segment<3>(kPosition);
  EXPECT_NEAR((moved / kFrame - y.segment<3>(kVelocity)).norm(), 0, 1e-13);
  Eigen::Vector4d back = x.segment<4>(kOrientation);
  back.tail<3>() *= -1;
  const Eigen::Vector4d dq = quaternion_product(back, y.segment<4>(kOrientation)).normalized();
  EXPECT_LT((quaternion_log(dq) / kFrame - y.segment<3>(kRate)).norm(), 1e-9);  // q has 10 digits
}

TEST(MotionModel, NoiseIsThatOfTheImpulsesThroughTheirDerivatives) {
  for (const double turning : {1.0, 0.0}) {
    RobotVector x = generic_state();
    x.segment<3>(kRate) *= turning;
    const auto f = [&](const Eigen::VectorXd& n) -> Eigen::VectorXd {  // an impulse acts before the motion
      RobotVector pushed = x;
      pushed.segment<3>(kVelocity) += n.head<3>();
      pushed.segment<3>(kRate) += n.tail<3>();
      return predict_motion(pushed, kFrame, std::nullopt, paper()).x;
    };
    const Eigen::MatrixXd G = tests::numerical_jacobian(f, Eigen::VectorXd::Zero(6));
    Eigen::VectorXd sigma(6);
    sigma << 4, 4, 4, 6, 6, 6;
    const Eigen::MatrixXd root = G * (kFrame * sigma).asDiagonal();
    const RobotMatrix Q = predict_motion(x, kFrame, std::nullopt, paper()).Q;
    EXPECT_LT((Q - root * root.transpose()).norm(), 1e-8);  // central differences of 1e-6
  }
}

TEST(MotionModel, AccelerometerAtRestCancelsGravity) {
  RobotVector x = RobotVector::Zero();
  x.segment<4>(kOrientation) = Eigen::Vector4d(0.9, 0.1, -0.2, 0.3).normalized();
  const Eigen::Matrix3d R_WC = rotation_matrix(x.segment<4>(kOrientation));
  const VelocityIncrement at_rest{R_WC.transpose() * Eigen::Vector3d(0, 0, 9.81) * kFrame, kFrame, 0.01};
  EXPECT_LT((predict_motion(x, kFrame, at_rest, paper()).x - x).norm(), 1e-15);
}

TEST(MotionModel, DoesNotDependOnTheSignOfTheQuaternion) {
  RobotVector flipped = generic_state();
  flipped.segment<4>(kOrientation) *= -1;
  const VelocityIncrement increment{{0.02, -0.33, 0.05}, kFrame, 0.001};
  RobotVector x = predict_motion(flipped, kFrame, increment, Options()).x;
  x.segment<4>(kOrientation) *= -1;
  EXPECT_EQ(x, predict_motion(generic_state(), kFrame, increment, Options()).x);
}

TEST(MotionModel, SwayingIsStationaryWithTheStandardDeviationOfTheOptions) {
  Options options = paper();
  options.plan_velocity.sigma_sway_m_s = 0.03;
  const double omega = 6.2831853 / options.plan_velocity.sway_period_s;
  const Prediction p = predict_motion(generic_state(), kFrame, std::nullopt, options);
  const std::array at{kSwayVelocity, kSwayPosition};
  const Eigen::Matrix2d F = p.F(at, at), Q = p.Q(at, at);
  Eigen::Matrix2d P = Eigen::Matrix2d::Zero();
  for (int k = 0; k < 30 * 60; ++k) P = F * P * F.transpose() + Q;
  // The discrete oscillation differs from the continuous one by ω dt/2 = 7 % and 1/(2 ω τ) = 13 %.
  EXPECT_NEAR(std::sqrt(P(0, 0)), 0.03, 0.1 * 0.03);
  EXPECT_NEAR(std::sqrt(P(1, 1)), 0.03 / omega, 0.15 * 0.03 / omega);
  const Eigen::Matrix2d later = F * P * F.transpose() + Q;
  EXPECT_LT((later - P).norm(), 1e-9 * P.norm());  // no part of it grows with time
  EXPECT_LT((sway_sigma(options.plan_velocity) - Eigen::Vector3d(0.03, 0.0045, 0.018)).norm(), 1e-17);
}

TEST(MotionModel, BiasesWalkAndTheStrideErrorDecaysToTheVarianceOfTheOptionsWhateverTheStep) {
  Options options;
  options.plan_velocity.sigma_stride = 0.05;
  options.gyro.sigma_bias_walk_rad_s2 = 0.003;
  options.accelerometer.sigma_bias_walk_m_s3 = 0.02;
  for (const double dt : {0.01, 0.5}) {
    const Prediction p = predict_motion(generic_state(), dt, std::nullopt, options);
    EXPECT_NEAR(p.Q(kGyroBias + 1, kGyroBias + 1) / dt, 0.003 * 0.003, 1e-17);
    EXPECT_NEAR(p.Q(kAccelerometerBias, kAccelerometerBias) / dt, 0.02 * 0.02, 1e-17);
    for (const int at : {kStrideError, kStrideError + 1}) {
      EXPECT_NEAR(p.x(at), generic_state()(at) * std::exp(-dt / 30), 1e-15);
      const double variance = 0.05 * 0.05;  // a fixed point of variance <- decay² variance + noise
      EXPECT_NEAR(p.F(at, at) * p.F(at, at) * variance + p.Q(at, at), variance, 1e-17);
    }
  }
}

const Eigen::Isometry3d kStart = pose(0.7, {1, -2, 2}, {1, 2, 3});

TEST(InitialState, IsAtRestAtTheGivenPoseWithTheStandardDeviationsOfTheOptions) {
  Options options;
  options.start = {0.1, 0.2, 0.3, 0.4};
  options.gyro.sigma_bias_rad_s = 0.5;
  options.accelerometer.sigma_bias_m_s2 = 0.6;
  options.plan_velocity.sigma_stride = 0.8;
  const RobotState initial = initial_state(kStart, options);
  EXPECT_EQ(initial.x.head<3>(), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((camera_pose(initial.x).linear() - kStart.linear()).norm(), 1e-15);
  EXPECT_EQ(initial.x.tail<kRobot - kVelocity>().norm(), 0);
  const RobotVector sigma = initial.P.diagonal().cwiseSqrt();
  for (const auto& [at, expected] : {std::pair{kPosition, 0.1},
                                     {kVelocity, 0.3},
                                     {kRate, 0.4},
                                     {kGyroBias, 0.5},
                                     {kAccelerometerBias, 0.6},
                                     {kStrideError, 0.8},
                                     {kSwayVelocity, options.plan_velocity.sigma_sway_m_s}})
    EXPECT_NEAR(sigma(at), expected, 1e-15) << at;
  const double omega = 2 * 3.14159265358979 / options.plan_velocity.sway_period_s;
  EXPECT_NEAR(sigma(kSwayPosition), options.plan_velocity.sigma_sway_m_s / omega, 1e-15);
  const Eigen::Vector4d q = initial.x.segment<4>(kOrientation);
  const Eigen::Matrix4d P = initial.P.block<4, 4>(kOrientation, kOrientation);
  EXPECT_LT((P * q).norm(), 1e-16);                  // varies by rotations only
  EXPECT_NEAR(P.trace(), 3 * 0.2 * 0.2 / 4, 1e-15);  // |∂q/∂θ| = 1/2 about each axis
}

}  // namespace
}  // namespace slam
