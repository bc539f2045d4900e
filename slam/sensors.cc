#include "slam/sensors.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slam {
namespace {

constexpr double kLongestGap_s = 0.001;
constexpr double kStanding = 1e-3;        // m/s and rad/s, for a plan
constexpr double kStandingByLegs = 0.02;  // for leg odometry, above the encoders' noise
// Standard deviation of the difference between plan and leg odometry after two steps: the robot sways, and
// lands earlier or later than planned.
constexpr double kTwoStepsSigma_m = 0.005;

bool covered(const std::vector<InertialSample>& samples, Stamp from, Stamp to) {
  double sum = 0;
  for (const InertialSample& s : samples)
    sum += std::max(0.0, seconds(std::min(s.end, to) - std::max(s.begin, from)));
  return sum > seconds(to - from) - kLongestGap_s;
}

/// ∫ weight · specific force dt over an interval, in the axes of the chest at the interval's start, and the
/// rotation of the chest over the interval. The weight rises from 0 to 1 or falls from 1 to 0.
struct WeightedIntegral {
  Eigen::Vector3d force_G = Eigen::Vector3d::Zero();
  Eigen::Vector4d rotation{1, 0, 0, 0};
  double squares = 0;  ///< Σ weight² dt · kReadingPeriod_s
};

WeightedIntegral integrate(const InertialInterval& interval, const Eigen::Vector3d& bias_G, bool rising) {
  WeightedIntegral sum;
  Stamp now{-1};
  auto gyro = interval.gyro.begin();
  const auto rotate_until = [&](Stamp t) {
    for (; gyro != interval.gyro.end(); ++gyro) {
      const Stamp end = std::min(t, gyro->end), begin = std::max(now, gyro->begin);
      if (end > begin)
        sum.rotation =
            quaternion_product(sum.rotation, quaternion_exp((gyro->value - bias_G) * seconds(end - begin)));
      if (gyro->end > t) break;
    }
    now = std::max(now, t);
  };
  const double duration = seconds(interval.to - interval.from);
  for (const InertialSample& sample : interval.accelerometer) {
    const Stamp begin = std::max(sample.begin, interval.from), end = std::min(sample.end, interval.to);
    if (end <= begin) continue;
    const Stamp middle = begin + (end - begin) / 2;
    rotate_until(middle);
    const double into = seconds(middle - interval.from) / duration;
    const double dt = seconds(end - begin), weight = rising ? into : 1 - into;
    sum.force_G += weight * dt * (rotation_matrix(sum.rotation) * sample.value);
    sum.squares += weight * weight * dt * kReadingPeriod_s;
  }
  rotate_until(interval.to);
  return sum;
}

/// Adds the horizontal motion of the camera due to unplanned rotation about the support foot: R(q)ᵀ D R(q)
/// (p_CF × (ω − ω_plan)).
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

/// The horizontal motion of the camera between two poses, along and to the left of its heading at the first
/// pose.
Eigen::Vector2d horizontal_motion(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  const Eigen::Vector2d ahead = from.linear().col(2).head<2>().normalized();
  const Eigen::Vector2d motion = (to.translation() - from.translation()).head<2>();
  return {ahead.dot(motion), ahead.x() * motion.y() - ahead.y() * motion.x()};
}

/// The mean velocity between two poses dt_s apart, along the axes of C. p_CF: mean position of the foot.
PlannedVelocity mean_velocity(const Eigen::Isometry3d& before, const Eigen::Isometry3d& now, double dt_s,
                              const Eigen::Vector3d& p_CF) {
  const Eigen::Vector3d v = (now.translation() - before.translation()) / dt_s;
  const Eigen::AngleAxisd turn(before.linear().transpose() * now.linear());
  return {now.linear().transpose() * v, turn.angle() / dt_s * turn.axis(), p_CF};
}

}  // namespace

std::optional<MeanRate> mean_rate(const InertialInterval& interval, const Options& options) {
  const auto& [from, to, gyro, accelerometer, X_CG_from, X_CG_to] = interval;
  if (options.gyro.readings == GyroReadings::last) {  // as in the paper: only the last one before the frame
    if (gyro.empty() || gyro.back().end <= from || gyro.back().end > to) return std::nullopt;
    return MeanRate{X_CG_to.linear() * gyro.back().value, options.gyro.sigma_rad_s};
  }
  const double dt = seconds(to - from);
  Eigen::Vector4d rotation(1, 0, 0, 0);
  double covered = 0;
  for (const InertialSample& sample : gyro) {
    const double part = seconds(std::min(sample.end, to) - std::max(sample.begin, from));
    if (part <= 0) continue;
    rotation = quaternion_product(rotation, quaternion_exp(sample.value * part));
    covered += part;
  }
  if (covered < 0.5 * dt) return std::nullopt;
  const double gap = std::max(0.0, dt - covered);
  const double sigma_gap = options.motion.sigma_angular_acceleration_rad_s2 * gap * gap / dt;
  const double sigma_readings = options.gyro.sigma_rad_s * std::sqrt(kReadingPeriod_s / covered);
  const Eigen::AngleAxisd turn(X_CG_from.linear() *
                               rotation_matrix(quaternion_exp(quaternion_log(rotation) * dt / covered)) *
                               X_CG_to.linear().transpose());
  return MeanRate{turn.angle() / dt * turn.axis(), std::hypot(sigma_readings, sigma_gap)};
}

Measurement measure_rate(const RobotVector& x, const MeanRate& rate, bool by_gyro) {
  Measurement m(3);
  m.innovation.head<3>() = rate.w_C - x.segment<3>(kRate);
  m.H_robot.middleCols(kRate, 3).setIdentity();
  m.R.diagonal().setConstant(rate.sigma_rad_s * rate.sigma_rad_s);
  if (!by_gyro) return m;
  m.innovation.head<3>() -= x.segment<3>(kGyroBias);
  m.H_robot.middleCols(kGyroBias, 3).setIdentity();
  return m;
}

std::optional<VelocityIncrement> velocity_increment(const InertialInterval& earlier,
                                                    const InertialInterval& later,
                                                    const Eigen::Vector3d& gyro_bias_C,
                                                    const Options& options) {
  for (const InertialInterval* i : {&earlier, &later})
    if (i->to <= i->from || !covered(i->accelerometer, i->from, i->to) || !covered(i->gyro, i->from, i->to))
      return std::nullopt;
  if (earlier.to != later.from) return std::nullopt;
  const Eigen::Matrix3d R_CG = later.X_CG_from.linear();
  const Eigen::Vector3d bias_G = R_CG.transpose() * gyro_bias_C;
  const WeightedIntegral before = integrate(earlier, bias_G, true), after = integrate(later, bias_G, false);
  const Eigen::Matrix3d back = rotation_matrix(before.rotation).transpose(),
                        ahead = rotation_matrix(after.rotation);

  const double d0 = seconds(earlier.to - earlier.from), d1 = seconds(later.to - later.from);
  const auto lever = [](const Eigen::Isometry3d& X_CG) -> Eigen::Vector3d {
    return X_CG.linear().transpose() * X_CG.translation();
  };
  const Eigen::Vector3d lever_G = lever(later.X_CG_from),
                        swing_G = (ahead * lever(later.X_CG_to) - lever_G) / d1 -
                                  (lever_G - back * lever(earlier.X_CG_from)) / d0;
  VelocityIncrement increment;
  increment.increment_C = R_CG * (back * before.force_G + after.force_G - swing_G);
  increment.duration_s = (d0 + d1) / 2;
  const double rate_sigma = options.gyro.sigma_rad_s * std::sqrt(kReadingPeriod_s * (1 / d0 + 1 / d1));
  const double force = options.accelerometer.sigma_m_s2 * std::sqrt(before.squares + after.squares);
  increment.sigma_m_s = std::hypot(force, rate_sigma * lever_G.norm(),
                                   options.accelerometer.sigma_head_m_s2 * increment.duration_s);
  return increment;
}

/// Compares the planned motion over two steps with the motion from leg odometry. Two steps are compared
/// because the robot sways more than planned within a step and as it starts to walk. Two steps that differ
/// from the two before, or the first two after standing, have less weight, because a small delay changes them
/// more. At every second landing, returns the evidence for the scale of the planned distances since the
/// landing before last. Starts over when the robot stands or leg odometry is missing.
SystematicEvidence PlanHistory::compare_two_steps(const Known& now, bool landed, bool standing) {
  if (!now.legs || standing) start_.reset(), planned_m_.reset();
  if (!now.legs || standing || !landed || (start_ && ++landings_ < 2)) return {};
  SystematicEvidence evidence;
  if (start_) {
    const Eigen::Vector2d by_legs = horizontal_motion(start_->legs->X_OC, now.legs->X_OC);
    const Eigen::Vector2d planned = horizontal_motion(start_->plan->X_PC, now.plan->X_PC);
    const double change_m = (planned - planned_m_.value_or(Eigen::Vector2d::Zero())).norm();
    const double weight = 1 / (kTwoStepsSigma_m * kTwoStepsSigma_m + change_m * change_m);
    evidence = {weight * by_legs.dot(planned - by_legs), weight * by_legs.squaredNorm()};
    planned_m_ = planned;
  }
  start_ = now;
  landings_ = 0;
  return evidence;
}

std::optional<PlannedInterval> PlanHistory::advance(const Observation& o, double dt_s,
                                                    const Options& options) {
  const Known before = std::exchange(previous_, {o.plan, o.legs});
  const std::optional<PlannedMotion>& plan = o.plan;
  const std::optional<LegMotion>& legs = o.legs;
  if (!plan) start_.reset(), planned_m_.reset();
  if (o.command)
    followed_m_s_ += (1 - std::exp(-dt_s / options.command.lag_s)) *
                     (Eigen::Vector2d(o.command->ahead_m_s, o.command->left_m_s) - followed_m_s_);
  const bool along_plan = options.plan_velocity.axes == VelocityAxes::plan;
  const bool by_legs = before.legs && legs && options.leg_odometry.enabled && !along_plan;
  PlannedInterval interval;
  if (before.plan && plan)
    interval.plan = mean_velocity(before.plan->X_PC, plan->X_PC, dt_s, (before.plan->p_CF + plan->p_CF) / 2);
  if (by_legs)
    interval.legs = mean_velocity(before.legs->X_OC, legs->X_OC, dt_s, (before.legs->p_CS + legs->p_CS) / 2);
  if (!interval.plan && !interval.legs) {
    if (!o.command || !options.command.enabled) return std::nullopt;
    interval.command = followed_m_s_;
    return interval;
  }
  PlannedVelocity& known = interval.plan ? *interval.plan : *interval.legs;
  // Averaged over the duration of two steps.
  const double keep = std::exp(-dt_s / options.plan_velocity.sway_period_s);
  steady_C_ = known.velocity + keep * (steady_C_ - known.velocity);
  const double standing = interval.plan ? kStanding : kStandingByLegs;
  interval.standing = known.velocity.norm() < standing && known.rate.norm() < standing;
  if (!interval.standing || moved_s_ > 0) moved_s_ += dt_s;
  interval.steady = moved_s_ > options.plan_velocity.sway_period_s;
  if (interval.plan) {
    const bool landed = plan->support != before.plan->support && before.plan->support != Support::both;
    interval.plan_scale = compare_two_steps(previous_, landed, interval.standing);
    interval.plan->steady_C = steady_C_;
    interval.plan->sigma_m_s = options.plan_velocity.sigma_m_s;
    if (along_plan)
      interval.plan->velocity = (plan->X_PC.translation() - before.plan->X_PC.translation()) / dt_s;
  }
  if (!interval.legs) return interval;
  if (options.leg_odometry.sigma_position_m > 0) interval.legs->between_positions_s = dt_s;
  interval.legs->steady_C = steady_C_;
  interval.legs->sigma_m_s = options.leg_odometry.sigma_m_s;
  interval.legs->sigma_pivot_m = options.leg_odometry.sigma_pivot_m;
  return interval;
}

Measurement measure_velocity(const RobotVector& x, const PlannedVelocity& planned,
                             const Options::PlanVelocity& options, int scale) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const Eigen::Vector3d v = x.segment<3>(kVelocity), steady = planned.steady_C;
  Eigen::Matrix<double, 3, 2> J_stride;  // with respect to its relative length and its angle about −y of C
  J_stride << steady.x(), -steady.z(), 0, 0, steady.z(), steady.x();
  Eigen::Matrix<double, 3, 2> J_sway = Eigen::Matrix<double, 3, 2>::Zero();  // with respect to kSwayScale
  J_sway(0, 0) = planned.velocity.x() - steady.x();
  J_sway(2, 1) = planned.velocity.z() - steady.z();
  const Eigen::Vector3d error =
      x.segment<3>(kSwayVelocity) + J_stride * x.segment<2>(kStrideError) + J_sway * x.segment<2>(kSwayScale);
  Measurement m(3);
  if (options.axes == VelocityAxes::robot) {
    m.innovation.head<3>() = planned.velocity - R_WC.transpose() * v - error;
    m.H_robot.middleCols(kOrientation, 4) = rotated_back_jacobian(q, v);
    m.H_robot.middleCols(kVelocity, 3) = R_WC.transpose();
    m.H_robot.middleCols(kSwayVelocity, 3).setIdentity();
    m.H_robot.middleCols(kStrideError, 2) = J_stride;
    m.H_robot.middleCols(kSwayScale, 2) = J_sway;
    m.sensitivity.col(scale).head<3>() = steady;
    if (options.pivots_on_foot) add_pivoting(x, planned, m);
    if (planned.between_positions_s > 0) {
      const double rate = 1 / planned.between_positions_s;
      m.innovation.head<3>() -= rate * (x.segment<3>(kLegError) - x.segment<3>(kPreviousLegError));
      m.H_robot.middleCols(kLegError, 3).diagonal().setConstant(rate);
      m.H_robot.middleCols(kPreviousLegError, 3).diagonal().setConstant(-rate);
    }
  } else {
    m.innovation.head<3>() = planned.velocity - v - R_WC * error;
    m.H_robot.middleCols(kOrientation, 4) = rotated_jacobian(q, error);
    m.H_robot.middleCols(kVelocity, 3).setIdentity();
    m.H_robot.middleCols(kSwayVelocity, 3) = R_WC;
    m.H_robot.middleCols(kStrideError, 2) = R_WC * J_stride;
    m.H_robot.middleCols(kSwayScale, 2) = R_WC * J_sway;
    m.sensitivity.col(scale).head<3>() = R_WC * steady;
  }
  const double tilting = planned.sigma_pivot_m * (x.segment<3>(kRate) - planned.rate).norm();
  m.R.diagonal().setConstant(planned.sigma_m_s * planned.sigma_m_s + tilting * tilting);
  return m;
}

Measurement measure_command(const RobotVector& x, const Eigen::Vector2d& commanded_m_s,
                            const Options::Command& options) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Vector3d v = x.segment<3>(kVelocity), axis(0, 0, 1), optical = rotation_matrix(q) * axis;
  const double length = optical.head<2>().norm();
  const Eigen::Vector2d ahead = optical.head<2>() / length, left(-ahead.y(), ahead.x());
  const Eigen::Vector2d seen(ahead.dot(v.head<2>()), left.dot(v.head<2>()));
  Eigen::Matrix2d J_stride;  // with respect to its relative length and its angle
  J_stride << commanded_m_s.x(), -commanded_m_s.y(), commanded_m_s.y(), commanded_m_s.x();
  Measurement m(2);
  m.innovation.head<2>() = commanded_m_s - seen - J_stride * x.segment<2>(kStrideError) -
                           Eigen::Vector2d(x(kSwayVelocity + 2), -x(kSwayVelocity));
  // The heading turns by left / length times the change of the optical axis.
  const Eigen::RowVector4d turn = left.transpose() / length * rotated_jacobian(q, axis).topRows<2>();
  m.H_robot.row(0).segment<4>(kOrientation) = seen.y() * turn;
  m.H_robot.row(1).segment<4>(kOrientation) = -seen.x() * turn;
  m.H_robot.row(0).segment<2>(kVelocity) = ahead.transpose();
  m.H_robot.row(1).segment<2>(kVelocity) = left.transpose();
  m.H_robot.block<2, 2>(0, kStrideError) = J_stride;
  m.H_robot(0, kSwayVelocity + 2) = 1;
  m.H_robot(1, kSwayVelocity) = -1;
  m.R.diagonal().setConstant(options.sigma_m_s * options.sigma_m_s);
  return m;
}

Measurement measure_height(const RobotVector& x, double height_m, const Options::Height& options) {
  Measurement m(1);
  m.innovation(0) = height_m - x(kPosition + 2) - x(kHeightError);
  m.H_robot(0, kPosition + 2) = m.H_robot(0, kHeightError) = 1;
  m.R(0, 0) = options.sigma_m * options.sigma_m;
  return m;
}

}  // namespace slam
