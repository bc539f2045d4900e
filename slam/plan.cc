#include "slam/plan.h"

#include <cmath>

namespace slam {
namespace {

constexpr double kStanding = 1e-3;  // m/s and rad/s
constexpr double kTwoSteps_s = 1.6;

/// Turning unknown to the plan takes the camera along, level: R(q)ᵀ D R(q) (p_CF × (ω − ω_plan)).
void add_pivoting(const RobotVector& x, const PlannedStride& stride, Measurement& m) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const Eigen::DiagonalMatrix<double, 3> level(1, 1, 0);
  const Eigen::Vector3d c_C = stride.p_CF.cross(x.segment<3>(kRate) - stride.rate);
  const Eigen::Vector3d c_W = level * (R_WC * c_C);
  m.innovation.head<3>() += R_WC.transpose() * c_W;
  m.H_robot.middleCols(kOrientation, 4) -=
      rotated_back_jacobian(q, c_W) + R_WC.transpose() * level * rotated_jacobian(q, c_C);
  m.H_robot.middleCols(kRate, 3) = -R_WC.transpose() * level * R_WC * cross_matrix(stride.p_CF);
}

/// What strides longer by a part, and turned by an angle about the vertical (minus y of C), add to the
/// planned velocity, in C: ∂v/∂kStride.
Eigen::Matrix<double, 3, 2> stride_errors(const Eigen::Vector3d& steady_C) {
  Eigen::Matrix<double, 3, 2> errors;
  errors.col(0) << steady_C.x(), 0, steady_C.z();
  errors.col(1) << -steady_C.z(), 0, steady_C.x();
  return errors;
}

}  // namespace

PlannedStride planned_stride(const PlannedMotion& before, const PlannedMotion& now, double dt_s,
                             VelocityAxes axes) {
  const Eigen::Vector3d v_P = (now.X_PC.translation() - before.X_PC.translation()) / dt_s;
  const Eigen::AngleAxisd turn(before.X_PC.linear().transpose() * now.X_PC.linear());
  const Eigen::Vector3d v_C = now.X_PC.linear().transpose() * v_P;
  return {axes == VelocityAxes::plan ? v_P : v_C, turn.angle() / dt_s * turn.axis(),
          (before.p_CF + now.p_CF) / 2, v_C};
}

Gait planned_gait(const PlannedMotion& before, const PlannedMotion& now, const PlannedStride& stride,
                  const Gait& till_then, double dt_s) {
  const bool lands = now.support != before.support && before.support != Support::both;
  Gait gait;
  gait.turning_rad_s = stride.rate.norm();
  gait.standing = stride.velocity.norm() < kStanding && gait.turning_rad_s < kStanding;
  gait.both_feet = now.support == Support::both;
  gait.steady_C = stride.steady_C + std::exp(-dt_s / kTwoSteps_s) * (till_then.steady_C - stride.steady_C);
  gait.since_landing_s = lands ? 0 : till_then.since_landing_s + dt_s;
  return gait;
}

double velocity_sigma(const Gait& gait, const Options::PlanVelocity& options) {
  double sigma = options.sigma_m_s;
  if (gait.standing) return sigma * options.standing_factor;
  if (gait.both_feet) sigma *= options.double_support_factor;
  if (gait.since_landing_s < options.landing_s) sigma *= options.landing_factor;
  return std::hypot(sigma, options.sigma_per_turn_m * gait.turning_rad_s);
}

Measurement measure_velocity(const RobotVector& x, const PlannedStride& stride,
                             const Options::PlanVelocity& options) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const Eigen::Vector3d v = x.segment<3>(kVelocity);
  const Eigen::Matrix<double, 3, 2> strides = stride_errors(stride.steady_C);
  const Eigen::Vector3d slip =
      x.segment<3>(kSlip) + x.segment<3>(kSwayVelocity) + strides * x.segment<2>(kStride);
  Measurement m(3);
  if (options.axes == VelocityAxes::robot) {
    m.innovation.head<3>() = stride.velocity - R_WC.transpose() * v - slip;
    m.H_robot.middleCols(kOrientation, 4) = rotated_back_jacobian(q, v);
    m.H_robot.middleCols(kVelocity, 3) = R_WC.transpose();
    m.H_robot.middleCols(kSlip, 3).setIdentity();
    m.H_robot.middleCols(kSwayVelocity, 3).setIdentity();
    m.H_robot.middleCols(kStride, 2) = strides;
    if (options.pivots_on_foot) add_pivoting(x, stride, m);
  } else {
    m.innovation.head<3>() = stride.velocity - v - R_WC * slip;
    m.H_robot.middleCols(kOrientation, 4) = rotated_jacobian(q, slip);
    m.H_robot.middleCols(kVelocity, 3).setIdentity();
    m.H_robot.middleCols(kSlip, 3) = R_WC;
    m.H_robot.middleCols(kSwayVelocity, 3) = R_WC;
    m.H_robot.middleCols(kStride, 2) = R_WC * strides;
  }
  m.R.diagonal().setConstant(options.sigma_m_s * options.sigma_m_s);
  return m;
}

Measurement measure_orientation(const RobotVector& x, const Eigen::Matrix3d& R_PC,
                                const Options::PlanOrientation& options) {
  const Eigen::Quaterniond planned(R_PC);
  const Eigen::Vector4d back(planned.w(), -planned.x(), -planned.y(), -planned.z());
  const Eigen::Vector4d turn = quaternion_product(back, x.segment<4>(kOrientation));
  const double sign = turn(0) < 0 ? -1 : 1;  // q and −q are the same orientation
  Measurement m(3);
  m.innovation.head<3>() = -2 * sign * turn.tail<3>();
  m.H_robot.middleCols(kOrientation, 4) = 2 * sign * left_matrix(back).bottomRows<3>();
  m.R.diagonal().setConstant(options.sigma_rad * options.sigma_rad);
  return m;
}

Measurement measure_position(const RobotVector& x, const Eigen::Vector3d& p_PC,
                             const Options::PlanPosition& options) {
  Measurement m(3);
  m.innovation.head<3>() = p_PC - x.segment<3>(kPosition);
  m.H_robot.middleCols(kPosition, 3).setIdentity();
  m.R.diagonal().setConstant(options.sigma_m * options.sigma_m);
  return m;
}

Measurement measure_height(const RobotVector& x, double height_m, const Options::Height& options) {
  Measurement m(1);
  m.innovation(0) = height_m - x(kPosition + 2);
  m.H_robot(0, kPosition + 2) = 1;
  m.R(0, 0) = options.sigma_m * options.sigma_m;
  return m;
}

}  // namespace slam
