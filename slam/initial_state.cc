#include "slam/initial_state.h"

#include <numbers>

#include "slam/motion_model.h"

namespace slam {

RobotVector initial_mean(const Eigen::Isometry3d& X_WC) {
  RobotVector x = RobotVector::Zero();
  const Eigen::Quaterniond q(X_WC.linear());
  x.segment<3>(kPosition) = X_WC.translation();
  x.segment<4>(kOrientation) << q.w(), q.x(), q.y(), q.z();
  return x;
}

RobotState initial_state(const Eigen::Isometry3d& X_WC, const Options& options) {
  const auto square = [](double a) { return a * a; };
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
  P.diagonal().segment<3>(kSlip).setConstant(square(options.plan_velocity.sigma_slip_m_s));
  P.diagonal().segment<2>(kStrideError).setConstant(square(options.plan_velocity.sigma_stride));
  const Eigen::Vector3d sway = sway_sigma(options.plan_velocity);
  P.diagonal().segment<3>(kSwayVelocity) = sway.cwiseAbs2();
  P.diagonal().segment<3>(kSwayPosition) =
      (sway * options.plan_velocity.sway_period_s / (2 * std::numbers::pi)).cwiseAbs2();
  return initial;
}

}  // namespace slam
