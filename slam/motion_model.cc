#include "slam/motion_model.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace slam {
namespace {

const Eigen::Vector3d kGravity_W(0, 0, -kGravity);  // m/s²
constexpr double kStrideTime_s = 30;  // correlation time of stride and sway errors, which last many steps
constexpr double kSwayTime_s = 1;     // correlation time of the amplitude and phase of the sway
constexpr double kSwayUp = 0.15, kSwayAhead = 0.6;  // relative to the lateral sway

double square(double a) { return a * a; }

/// Q = G diag(σ_V², σ_Ω²) Gᵀ, where G maps the impulses to velocity, rate and pose.
RobotMatrix impulse_covariance(const Matrix43d& dq_dw, double dt, double sigma_V, double sigma_W) {
  Eigen::Matrix<double, kRobot, 6> G = Eigen::Matrix<double, kRobot, 6>::Zero();
  G.block<3, 3>(kPosition, 0) = dt * Eigen::Matrix3d::Identity();
  G.block<3, 3>(kVelocity, 0).setIdentity();
  G.block<4, 3>(kOrientation, 3) = dq_dw;
  G.block<3, 3>(kRate, 3).setIdentity();
  Eigen::Matrix<double, 6, 1> variance;
  variance.head<3>().setConstant(square(sigma_V));
  variance.tail<3>().setConstant(square(sigma_W));
  const Eigen::Matrix<double, kRobot, 6> scaled = G * variance.asDiagonal();
  RobotMatrix Q;
  multiply_transposed(scaled, G, Q);
  return Q;
}

/// Unplanned swaying is a damped oscillation of the displacement d from the planned position, driven by
/// noise: u⁺ = e^(−dt/τ) u − ω² dt d, d⁺ = d + dt u⁺. The standard deviation of u is σ, and of d about
/// σ/ω.
void add_swaying(double dt, const Options::PlanVelocity& options, Prediction& prediction) {
  const double decay = std::exp(-dt / kSwayTime_s);
  const double spring = square(2 * std::numbers::pi / options.sway_period_s) * dt;
  Eigen::Matrix2d F;  // transition of (u, d)
  F << decay, -spring, dt * decay, 1 - dt * spring;
  const Eigen::Vector2d G(1, dt);
  const Eigen::Matrix2d Q = (1 - decay * decay) * G * G.transpose();
  const Eigen::Vector3d sigma = sway_sigma(options);
  for (int axis = 0; axis < 3; ++axis) {
    const std::array at{kSwayVelocity + axis, kSwayPosition + axis};
    const Eigen::Vector2d before = prediction.x(at);
    prediction.x(at) = F * before;
    prediction.F(at, at) = F;
    prediction.Q(at, at) = square(sigma(axis)) * Q;
  }
}

/// Predicts the biases of gyro and accelerometer and the lasting errors of stride, sway and height.
void add_sensor_errors(double dt, const Options& options, Prediction& prediction) {
  const auto decays = [&](int at, int count, double sigma, double time_s) {
    const double decay = std::exp(-dt / time_s);
    prediction.x.segment(at, count) *= decay;
    prediction.F.diagonal().segment(at, count).setConstant(decay);
    prediction.Q.diagonal().segment(at, count).setConstant(square(sigma) * (1 - decay * decay));
  };
  decays(kStrideError, 2, options.plan_velocity.sigma_stride, kStrideTime_s);
  decays(kSwayScale, 2, options.plan_velocity.sigma_sway_scale, kStrideTime_s);
  decays(kHeightError, 1, options.height.sigma_lasting_m, options.height.lasting_s);
  // Position errors are independent from frame to frame.
  prediction.x.segment<3>(kPreviousLegError) = prediction.x.segment<3>(kLegError);
  prediction.x.segment<3>(kLegError).setZero();
  prediction.F.block<6, 6>(kLegError, kLegError).setZero();
  prediction.F.block<3, 3>(kPreviousLegError, kLegError).setIdentity();
  prediction.Q.diagonal().segment<3>(kLegError).setConstant(square(options.leg_odometry.sigma_position_m));
  const auto random_walk = [&](int at, double variance) {
    prediction.Q.block<3, 3>(at, at).diagonal().setConstant(variance);
  };
  random_walk(kGyroBias, square(options.gyro.sigma_bias_walk_rad_s2) * dt);
  random_walk(kAccelerometerBias, square(options.accelerometer.sigma_bias_walk_m_s3) * dt);
}

/// Adds the accelerometer's velocity increment to the mean of velocity and position, and to F.
void add_increment(const RobotVector& x, const VelocityIncrement& increment, double dt,
                   Prediction& prediction) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Vector3d V_C = increment.increment_C - increment.duration_s * x.segment<3>(kAccelerometerBias);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const Eigen::Vector3d V = R_WC * V_C + increment.duration_s * kGravity_W;
  const Matrix34d dV_dq = rotated_jacobian(q, V_C);
  for (const auto& [row, factor] : {std::pair{kPosition, dt}, std::pair{kVelocity, 1.0}}) {
    prediction.x.segment<3>(row) += factor * V;
    prediction.F.block<3, 4>(row, kOrientation) = factor * dV_dq;
    prediction.F.block<3, 3>(row, kAccelerometerBias) = -factor * increment.duration_s * R_WC;
  }
}

}  // namespace

Eigen::Vector3d sway_sigma(const Options::PlanVelocity& options) {
  return options.sigma_sway_m_s * Eigen::Vector3d(1, kSwayUp, kSwayAhead);
}

Prediction predict_motion(const RobotVector& x, double dt, const std::optional<VelocityIncrement>& increment,
                          const Options& options, const std::optional<MeanRate>& rate) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  Eigen::Vector3d w = x.segment<3>(kRate);
  if (rate) w = rate->w_C - x.segment<3>(kGyroBias);
  const Eigen::Vector3d turn = w * dt;
  const Eigen::Vector4d dq = quaternion_exp(turn);
  const Matrix43d dq_dw = left_matrix(q) * quaternion_exp_jacobian(turn) * dt;
  const double sigma_V = increment ? increment->sigma_m_s : options.motion.sigma_acceleration_m_s2 * dt;
  const double sigma_W = rate ? std::hypot(rate->sigma_rad_s, options.gyro.sigma_head_rad_s)
                              : options.motion.sigma_angular_acceleration_rad_s2 * dt;

  Prediction prediction{x, RobotMatrix::Identity(), impulse_covariance(dq_dw, dt, sigma_V, sigma_W)};
  prediction.x.segment<3>(kPosition) += x.segment<3>(kVelocity) * dt;
  prediction.x.segment<4>(kOrientation) = quaternion_product(q, dq);
  prediction.F.block<3, 3>(kPosition, kVelocity) = dt * Eigen::Matrix3d::Identity();
  prediction.F.block<4, 4>(kOrientation, kOrientation) = right_matrix(dq);
  prediction.x.segment<3>(kRate) = w;
  if (rate) prediction.F.block<3, 3>(kRate, kRate).setZero();
  if (rate) prediction.F.block<3, 3>(kRate, kGyroBias).diagonal().setConstant(-1);
  prediction.F.block<4, 3>(kOrientation, rate ? kGyroBias : kRate) = (rate ? -1 : 1) * dq_dw;
  if (increment) add_increment(x, *increment, dt, prediction);
  add_sensor_errors(dt, options, prediction);
  add_swaying(dt, options.plan_velocity, prediction);
  return prediction;
}

RobotVector initial_mean(const Eigen::Isometry3d& X_WC) {
  RobotVector x = RobotVector::Zero();
  const Eigen::Quaterniond q(X_WC.linear());
  x.segment<3>(kPosition) = X_WC.translation();
  x.segment<4>(kOrientation) << q.w(), q.x(), q.y(), q.z();
  return x;
}

Options with_command(Options options) {
  options.plan_velocity.sigma_stride = options.command.sigma_stride;
  options.plan_velocity.sigma_sway_m_s = options.command.sigma_sway_m_s;
  return options;
}

Options with_leg_odometry(Options options) {
  if (!options.leg_odometry.enabled) return options;
  options.plan_velocity.sigma_stride = options.leg_odometry.sigma_stride;
  options.plan_velocity.sigma_sway_m_s = options.leg_odometry.sigma_sway_m_s;
  options.plan_velocity.sigma_sway_scale = options.leg_odometry.sigma_sway_scale;
  return options;
}

Options on_any_floor(Options options) {
  options.height.sigma_lasting_m = std::max(options.height.sigma_lasting_m, 0.03);
  options.height.lasting_s = std::max(options.height.lasting_s, 30.0);
  return options;
}

Options without_plan(Options options) {
  Options::Start& start = options.start;
  start.sigma_position_m = std::max(start.sigma_position_m, 0.003);
  start.sigma_orientation_rad = std::max(start.sigma_orientation_rad, 0.004);
  start.sigma_velocity_m_s = std::max(start.sigma_velocity_m_s, 0.3);
  start.sigma_rate_rad_s = std::max(start.sigma_rate_rad_s, 0.3);
  return on_any_floor(options);
}

RobotState initial_state(const Eigen::Isometry3d& X_WC, const Options& options) {
  RobotState initial{initial_mean(X_WC), RobotMatrix::Zero()};
  RobotMatrix& P = initial.P;
  P.diagonal().segment<3>(kPosition).setConstant(square(options.start.sigma_position_m));
  const Matrix43d dq = small_rotation_jacobian(initial.x.segment<4>(kOrientation));
  P.block<4, 4>(kOrientation, kOrientation) =
      square(options.start.sigma_orientation_rad) * dq * dq.transpose();
  P.diagonal().segment<3>(kVelocity).setConstant(square(options.start.sigma_velocity_m_s));
  P.diagonal().segment<3>(kRate).setConstant(square(options.start.sigma_rate_rad_s));
  P.diagonal().segment<3>(kGyroBias).setConstant(square(options.gyro.sigma_bias_rad_s));
  P.diagonal().segment<3>(kAccelerometerBias).setConstant(square(options.accelerometer.sigma_bias_m_s2));
  P.diagonal().segment<3>(kLegError).setConstant(square(options.leg_odometry.sigma_position_m));
  P(kHeightError, kHeightError) = square(options.height.sigma_lasting_m);
  P.diagonal().segment<2>(kSwayScale).setConstant(square(options.plan_velocity.sigma_sway_scale));
  P.diagonal().segment<2>(kStrideError).setConstant(square(options.plan_velocity.sigma_stride));
  const Eigen::Vector3d sway = sway_sigma(options.plan_velocity);
  P.diagonal().segment<3>(kSwayVelocity) = sway.cwiseAbs2();
  P.diagonal().segment<3>(kSwayPosition) =
      (sway * options.plan_velocity.sway_period_s / (2 * std::numbers::pi)).cwiseAbs2();
  return initial;
}

}  // namespace slam
