#include "slam/plan.h"

#include <cmath>

namespace slam {
namespace {

constexpr double kStanding = 1e-3;  // m/s and rad/s
constexpr double kTwoSteps_s = 1.6;
// Of the difference between plan and leg odometry after two steps: the robot sways, and lands earlier or
// later than planned.
constexpr double kTwoStepsSigma_m = 0.005;

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

/// True where a foot has been set down since the frame in which `before` carried.
bool lands(Support before, Support now) { return now != before && before != Support::both; }

/// The horizontal way from one pose to another of the camera, along the heading that it had and to its left.
Eigen::Vector2d horizontal_way(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  const Eigen::Vector2d ahead = from.linear().col(2).head<2>().normalized();
  const Eigen::Vector2d way = (to.translation() - from.translation()).head<2>();
  return {ahead.dot(way), ahead.x() * way.y() - ahead.y() * way.x()};
}

LegVelocity leg_velocity(const LegMotion& before, const LegMotion& now, double dt_s) {
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
                  const Gait& previous, double dt_s) {
  Gait gait;
  gait.turning_rad_s = planned.rate.norm();
  gait.standing = planned.velocity.norm() < kStanding && gait.turning_rad_s < kStanding;
  gait.double_support = now.support == Support::both;
  gait.steady_C = planned.steady_C + std::exp(-dt_s / kTwoSteps_s) * (previous.steady_C - planned.steady_C);
  gait.since_landing_s = lands(before.support, now.support) ? 0 : previous.since_landing_s + dt_s;
  return gait;
}

double velocity_sigma(const Gait& gait, const Options::PlanVelocity& options) {
  double sigma = options.sigma_m_s;
  if (gait.standing) return sigma * options.standing_factor;
  if (gait.double_support) sigma *= options.double_support_factor;
  if (gait.since_landing_s < options.landing_s) sigma *= options.landing_factor;
  return std::hypot(sigma, options.sigma_per_turn_m * gait.turning_rad_s);
}

Options::PlanVelocity noises_by_legs(const Options& options) {
  Options::PlanVelocity noises = options.plan_velocity;
  noises.sigma_m_s = options.leg_odometry.sigma_m_s;
  noises.landing_factor = options.leg_odometry.landing_factor;
  noises.landing_s = options.leg_odometry.landing_s;
  noises.sigma_stride = options.leg_odometry.sigma_stride;
  noises.sigma_sway_m_s = options.leg_odometry.sigma_sway_m_s;
  return noises;
}

SystematicEvidence TwoSteps::take(const PlannedMotion& before, const PlannedMotion& now, bool standing) {
  if (!now.legs || standing) begin_.reset();
  if (!now.legs || standing || !lands(before.support, now.support)) return {};
  if (begin_ && ++landings_ < 2) return {};
  SystematicEvidence evidence;
  if (begin_) {
    const Eigen::Vector2d by_legs = horizontal_way(begin_->legs->X_OC, now.legs->X_OC);
    const Eigen::Vector2d too_far = horizontal_way(begin_->X_PC, now.X_PC) - by_legs;
    const double weight = 1 / (kTwoStepsSigma_m * kTwoStepsSigma_m);
    evidence = {weight * by_legs.dot(too_far), weight * by_legs.squaredNorm()};
  }
  begin_ = now;
  landings_ = 0;
  return evidence;
}

std::optional<PlannedVelocity> PlanHistory::advance(const std::optional<PlannedMotion>& plan, double dt_s,
                                                    const Options& options) {
  std::optional<PlannedVelocity> planned;
  if (previous_ && plan) {
    planned = planned_velocity(*previous_, *plan, dt_s, options.plan_velocity.axes);
    gait_ = planned_gait(*previous_, *plan, *planned, gait_, dt_s);
    planned->steady_C = gait_.steady_C;
    moved_ = moved_ || !gait_.standing;
    const SystematicEvidence plan_scale = two_steps_.take(*previous_, *plan, gait_.standing);
    planned->sigma_m_s = velocity_sigma(gait_, options.plan_velocity);
    const bool by_legs = options.leg_odometry.enabled && options.plan_velocity.axes == VelocityAxes::robot;
    if (by_legs && previous_->legs && plan->legs) {
      planned->legs = leg_velocity(*previous_->legs, *plan->legs, dt_s);
      planned->legs->sigma_m_s = velocity_sigma(gait_, noises_by_legs(options));
      planned->legs->plan_scale = plan_scale;
    }
  }
  if (!plan) two_steps_ = {};
  previous_ = plan;
  return planned;
}

Measurement measure_leg_velocity(const RobotVector& x, const PlannedVelocity& planned,
                                 const Options::PlanVelocity& options) {
  PlannedVelocity measured = planned;
  measured.velocity = planned.legs->velocity;
  measured.rate = planned.legs->rate;
  measured.p_CF = planned.legs->p_CS;
  measured.sigma_m_s = planned.legs->sigma_m_s;
  Measurement m = measure_velocity(x, measured, options);
  m.sensitivity.col(kLegScale).swap(m.sensitivity.col(kPlanScale));
  return m;
}

Measurement measure_velocity(const RobotVector& x, const PlannedVelocity& planned,
                             const Options::PlanVelocity& options) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const Eigen::Vector3d v = x.segment<3>(kVelocity);
  const Eigen::Matrix<double, 3, 2> J_stride = stride_error_jacobian(planned.steady_C);
  const Eigen::Vector3d error =
      x.segment<3>(kSlip) + x.segment<3>(kSwayVelocity) + J_stride * x.segment<2>(kStrideError);
  Measurement m(3);
  if (options.axes == VelocityAxes::robot) {
    m.innovation.head<3>() = planned.velocity - R_WC.transpose() * v - error;
    m.H_robot.middleCols(kOrientation, 4) = rotated_back_jacobian(q, v);
    m.H_robot.middleCols(kVelocity, 3) = R_WC.transpose();
    m.H_robot.middleCols(kSlip, 3).setIdentity();
    m.H_robot.middleCols(kSwayVelocity, 3).setIdentity();
    m.H_robot.middleCols(kStrideError, 2) = J_stride;
    m.sensitivity.col(kPlanScale).head<3>() = planned.steady_C;
    if (options.pivots_on_foot) add_pivoting(x, planned, m);
  } else {
    m.innovation.head<3>() = planned.velocity - v - R_WC * error;
    m.H_robot.middleCols(kOrientation, 4) = rotated_jacobian(q, error);
    m.H_robot.middleCols(kVelocity, 3).setIdentity();
    m.H_robot.middleCols(kSlip, 3) = R_WC;
    m.H_robot.middleCols(kSwayVelocity, 3) = R_WC;
    m.H_robot.middleCols(kStrideError, 2) = R_WC * J_stride;
    m.sensitivity.col(kPlanScale).head<3>() = R_WC * planned.steady_C;
  }
  m.R.diagonal().setConstant(planned.sigma_m_s * planned.sigma_m_s);
  return m;
}

Measurement measure_orientation(const RobotVector& x, const Eigen::Matrix3d& R_PC,
                                const Options::PlanOrientation& options) {
  const Eigen::Quaterniond planned(R_PC);
  const Eigen::Vector4d inverse(planned.w(), -planned.x(), -planned.y(), -planned.z());
  const Eigen::Vector4d rotation = quaternion_product(inverse, x.segment<4>(kOrientation));
  const double sign = rotation(0) < 0 ? -1 : 1;  // q and −q are the same orientation
  Measurement m(3);
  m.innovation.head<3>() = -2 * sign * rotation.tail<3>();
  m.H_robot.middleCols(kOrientation, 4) = 2 * sign * left_matrix(inverse).bottomRows<3>();
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
