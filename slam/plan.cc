#include "slam/plan.h"

#include <cmath>

namespace slam {
namespace {

constexpr double kStanding = 1e-3;  // m/s and rad/s

}  // namespace

PlannedStride planned_stride(const PlannedMotion& before, const PlannedMotion& now, double dt_s,
                             VelocityAxes axes) {
  const Eigen::Vector3d v_P = (now.X_PC.translation() - before.X_PC.translation()) / dt_s;
  const Eigen::AngleAxisd turn(before.X_PC.linear().transpose() * now.X_PC.linear());
  return {axes == VelocityAxes::plan ? v_P : Eigen::Vector3d(now.X_PC.linear().transpose() * v_P),
          turn.angle() / dt_s * turn.axis(), (before.p_CF + now.p_CF) / 2};
}

Gait planned_gait(const PlannedMotion& before, const PlannedMotion& now, const PlannedStride& stride,
                  const Gait& till_then, double dt_s) {
  const bool lands = now.support != before.support && before.support != Support::both;
  Gait gait;
  gait.turning_rad_s = stride.rate.norm();
  gait.standing = stride.velocity.norm() < kStanding && gait.turning_rad_s < kStanding;
  gait.both_feet = now.support == Support::both;
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
  const Eigen::Vector3d v = x.segment<3>(kVelocity), slip = x.segment<3>(kSlip) + x.segment<3>(kSwayVelocity);
  Measurement m(3);
  if (options.axes == VelocityAxes::robot) {
    m.innovation.head<3>() = stride.velocity - R_WC.transpose() * v - slip;
    m.H_robot.middleCols(kOrientation, 4) = rotated_back_jacobian(q, v);
    m.H_robot.middleCols(kVelocity, 3) = R_WC.transpose();
    m.H_robot.middleCols(kSlip, 3).setIdentity();
    m.H_robot.middleCols(kSwayVelocity, 3).setIdentity();
    if (options.pivots_on_foot) {
      m.innovation.head<3>() += stride.p_CF.cross(x.segment<3>(kRate) - stride.rate);
      m.H_robot.middleCols(kRate, 3) = -cross_matrix(stride.p_CF);
    }
  } else {
    m.innovation.head<3>() = stride.velocity - v - R_WC * slip;
    m.H_robot.middleCols(kOrientation, 4) = rotated_jacobian(q, slip);
    m.H_robot.middleCols(kVelocity, 3).setIdentity();
    m.H_robot.middleCols(kSlip, 3) = R_WC;
    m.H_robot.middleCols(kSwayVelocity, 3) = R_WC;
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
