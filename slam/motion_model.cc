#include "slam/motion_model.h"

#include <cmath>

namespace slam {
namespace {

double square(double a) { return a * a; }

/// Q = G diag(σ_V², σ_Ω²) Gᵀ: the impulses reach velocity, rate and, through them, the pose.
RobotMatrix impulse_covariance(const Matrix43d& dq_dw, double dt, const Options::Motion& motion) {
  Eigen::Matrix<double, kRobot, 6> G = Eigen::Matrix<double, kRobot, 6>::Zero();
  G.block<3, 3>(kPosition, 0) = dt * Eigen::Matrix3d::Identity();
  G.block<3, 3>(kVelocity, 0).setIdentity();
  G.block<4, 3>(kOrientation, 3) = dq_dw;
  G.block<3, 3>(kRate, 3).setIdentity();
  Eigen::Matrix<double, 6, 1> variance;
  variance.head<3>().setConstant(square(motion.sigma_acceleration_m_s2 * dt));
  variance.tail<3>().setConstant(square(motion.sigma_angular_acceleration_rad_s2 * dt));
  return G * variance.asDiagonal() * G.transpose();
}

/// What the slowly changing errors of gyro and plan add to F and Q.
void add_sensor_errors(double dt, const Options& options, Prediction& prediction) {
  const double keep = std::exp(-dt / options.plan_velocity.slip_time_s);
  prediction.x.segment<3>(kSlip) *= keep;
  prediction.F.block<3, 3>(kSlip, kSlip).diagonal().setConstant(keep);
  prediction.Q.block<3, 3>(kSlip, kSlip)
      .diagonal()
      .setConstant(square(options.plan_velocity.sigma_slip_m_s) * (1 - keep * keep));
  prediction.Q.block<3, 3>(kGyroBias, kGyroBias)
      .diagonal()
      .setConstant(square(options.gyro.sigma_bias_walk_rad_s2) * dt);
}

}  // namespace

Prediction predict_motion(const RobotVector& x, double dt, const Options& options) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Vector3d turn = x.segment<3>(kRate) * dt;
  const Eigen::Vector4d dq = quaternion_exp(turn);
  const Matrix43d dq_dw = left_matrix(q) * quaternion_exp_jacobian(turn) * dt;

  Prediction prediction{x, RobotMatrix::Identity(), impulse_covariance(dq_dw, dt, options.motion)};
  prediction.x.segment<3>(kPosition) += x.segment<3>(kVelocity) * dt;
  prediction.x.segment<4>(kOrientation) = quaternion_product(q, dq);
  prediction.F.block<3, 3>(kPosition, kVelocity) = dt * Eigen::Matrix3d::Identity();
  prediction.F.block<4, 4>(kOrientation, kOrientation) = right_matrix(dq);
  prediction.F.block<4, 3>(kOrientation, kRate) = dq_dw;
  add_sensor_errors(dt, options, prediction);
  return prediction;
}

}  // namespace slam
