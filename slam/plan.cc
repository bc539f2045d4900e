#include "slam/plan.h"

#include <cmath>

namespace slam {
namespace {

constexpr double kStanding = 1e-3;  // m/s and rad/s
// Difference between plan and leg odometry after two steps: the robot sways, and lands earlier or later than
// planned.
constexpr double kTwoStepsSigma_m = 0.005;
constexpr double kLandingFactor = 6, kLanding_s = 0.2;  // while a foot settles, tuned on the training walks

/// Adds the horizontal motion of the camera by unplanned rotation about the support foot:
/// R(q)ᵀ D R(q) (p_CF × (ω − ω_plan)).
void add_pivoting(const RobotVector& x, const PlannedVelocity& planned, Measurement& m) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const Eigen::DiagonalMatrix<double, 3> horizontal(1, 1, 0);
  const Eigen::Vector3d c_C = planned.p_CF.cross(x.segment<3>(kRate) - planned.rate);
  const Eigen::Vector3d c_W = horizontal * (R_WC * c_C);
  m.innovation.head<3>() += R_WC.transpose() * c_W;
  m.H_robot.middleCols(kOrientation, 4) -=
      rotated_back_jacobian(q, c_W) + R_WC.transpose() * horizontal * rotated_jacobian(q, c_C);
  m.H_robot.middleCols(kRate, 3) = -R_WC.transpose() * horizontal * R_WC * cross_matrix(planned.p_CF);
}

/// The derivative of the planned velocity in C with respect to the stride error: relative length, and angle
/// about the vertical, which is minus y of C.
Eigen::Matrix<double, 3, 2> stride_error_jacobian(const Eigen::Vector3d& steady_C) {
  Eigen::Matrix<double, 3, 2> J;
  J.col(0) << steady_C.x(), 0, steady_C.z();
  J.col(1) << -steady_C.z(), 0, steady_C.x();
  return J;
}

/// The mean angular velocity between two poses dt_s apart, rad/s in C.
Eigen::Vector3d mean_rate(const Eigen::Isometry3d& before, const Eigen::Isometry3d& now, double dt_s) {
  const Eigen::AngleAxisd turn(before.linear().transpose() * now.linear());
  return turn.angle() / dt_s * turn.axis();
}

/// True if a foot has been set down since the frame with the support `before`.
bool lands(Support before, Support now) { return now != before && before != Support::both; }

/// The horizontal motion of the camera between two poses, along its heading at the first and to its left.
Eigen::Vector2d horizontal_motion(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  const Eigen::Vector2d ahead = from.linear().col(2).head<2>().normalized();
  const Eigen::Vector2d motion = (to.translation() - from.translation()).head<2>();
  return {ahead.dot(motion), ahead.x() * motion.y() - ahead.y() * motion.x()};
}

PlannedVelocity leg_velocity(const LegMotion& before, const LegMotion& now, double dt_s) {
  const Eigen::Vector3d v_O = (now.X_OC.translation() - before.X_OC.translation()) / dt_s;
  return {now.X_OC.linear().transpose() * v_O, mean_rate(before.X_OC, now.X_OC, dt_s),
          (before.p_CS + now.p_CS) / 2};
}

}  // namespace

PlannedVelocity planned_velocity(const PlannedMotion& before, const PlannedMotion& now, double dt_s,
                                 VelocityAxes axes) {
  const Eigen::Vector3d v_P = (now.X_PC.translation() - before.X_PC.translation()) / dt_s;
  const Eigen::Vector3d v_C = now.X_PC.linear().transpose() * v_P;
  return {axes == VelocityAxes::plan ? v_P : v_C, mean_rate(before.X_PC, now.X_PC, dt_s),
          (before.p_CF + now.p_CF) / 2, v_C};
}

Gait planned_gait(const PlannedMotion& before, const PlannedMotion& now, const PlannedVelocity& planned,
                  const Gait& previous, double dt_s, double two_steps_s) {
  Gait gait;
  gait.standing = planned.velocity.norm() < kStanding && planned.rate.norm() < kStanding;
  gait.steady_C = planned.steady_C + std::exp(-dt_s / two_steps_s) * (previous.steady_C - planned.steady_C);
  gait.since_landing_s = lands(before.support, now.support) ? 0 : previous.since_landing_s + dt_s;
  return gait;
}

double leg_velocity_sigma(const Gait& gait, const Options::LegOdometry& options) {
  const bool landing = !gait.standing && gait.since_landing_s < kLanding_s;
  return landing ? options.sigma_m_s * kLandingFactor : options.sigma_m_s;
}

Options with_leg_noises(const Options& options) {
  Options noises = options;
  noises.plan_velocity.sigma_stride = options.leg_odometry.sigma_stride;
  noises.plan_velocity.sigma_sway_m_s = options.leg_odometry.sigma_sway_m_s;
  return noises;
}

SystematicEvidence TwoSteps::add(const PlannedMotion& before, const PlannedMotion& now, bool standing) {
  if (!now.legs || standing) start_.reset();
  if (!now.legs || standing || !lands(before.support, now.support)) return {};
  if (start_ && ++landings_ < 2) return {};
  SystematicEvidence evidence;
  if (start_) {
    const Eigen::Vector2d by_legs = horizontal_motion(start_->legs->X_OC, now.legs->X_OC);
    const Eigen::Vector2d too_far = horizontal_motion(start_->X_PC, now.X_PC) - by_legs;
    const double weight = 1 / (kTwoStepsSigma_m * kTwoStepsSigma_m);
    evidence = {weight * by_legs.dot(too_far), weight * by_legs.squaredNorm()};
  }
  start_ = now;
  landings_ = 0;
  return evidence;
}

std::optional<PlannedInterval> PlanHistory::advance(const std::optional<PlannedMotion>& plan, double dt_s,
                                                    const Options& options) {
  std::optional<PlannedInterval> interval;
  if (previous_ && plan) {
    PlannedVelocity planned = planned_velocity(*previous_, *plan, dt_s, options.plan_velocity.axes);
    gait_ = planned_gait(*previous_, *plan, planned, gait_, dt_s, options.plan_velocity.sway_period_s);
    planned.steady_C = gait_.steady_C;
    planned.sigma_m_s = options.plan_velocity.sigma_m_s;
    moved_ = moved_ || !gait_.standing;
    interval = {planned, std::nullopt, two_steps_.add(*previous_, *plan, gait_.standing)};
    const bool by_legs = options.leg_odometry.enabled && options.plan_velocity.axes == VelocityAxes::robot;
    if (by_legs && previous_->legs && plan->legs) {
      interval->legs = leg_velocity(*previous_->legs, *plan->legs, dt_s);
      interval->legs->steady_C = gait_.steady_C;
      interval->legs->sigma_m_s = leg_velocity_sigma(gait_, options.leg_odometry);
    }
  }
  if (!plan) two_steps_ = {};
  previous_ = plan;
  return interval;
}

Measurement measure_velocity(const RobotVector& x, const PlannedVelocity& planned,
                             const Options::PlanVelocity& options, int scale) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const Eigen::Vector3d v = x.segment<3>(kVelocity);
  const Eigen::Matrix<double, 3, 2> J_stride = stride_error_jacobian(planned.steady_C);
  const Eigen::Vector3d error = x.segment<3>(kSwayVelocity) + J_stride * x.segment<2>(kStrideError);
  Measurement m(3);
  if (options.axes == VelocityAxes::robot) {
    m.innovation.head<3>() = planned.velocity - R_WC.transpose() * v - error;
    m.H_robot.middleCols(kOrientation, 4) = rotated_back_jacobian(q, v);
    m.H_robot.middleCols(kVelocity, 3) = R_WC.transpose();
    m.H_robot.middleCols(kSwayVelocity, 3).setIdentity();
    m.H_robot.middleCols(kStrideError, 2) = J_stride;
    m.sensitivity.col(scale).head<3>() = planned.steady_C;
    if (options.pivots_on_foot) add_pivoting(x, planned, m);
  } else {
    m.innovation.head<3>() = planned.velocity - v - R_WC * error;
    m.H_robot.middleCols(kOrientation, 4) = rotated_jacobian(q, error);
    m.H_robot.middleCols(kVelocity, 3).setIdentity();
    m.H_robot.middleCols(kSwayVelocity, 3) = R_WC;
    m.H_robot.middleCols(kStrideError, 2) = R_WC * J_stride;
    m.sensitivity.col(scale).head<3>() = R_WC * planned.steady_C;
  }
  m.R.diagonal().setConstant(planned.sigma_m_s * planned.sigma_m_s);
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
