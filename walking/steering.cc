#include "walking/steering.h"

#include <algorithm>
#include <cmath>

namespace walking {
namespace {

/// Ticks from the last landing to the decision whether the end of the path has been reached.
constexpr std::size_t kSettlingTicks = 160;

}  // namespace

PlaceEstimate place_by_legs(const Eigen::Isometry3d& X_OB, const Reference& planned, bool has_plan) {
  Eigen::Isometry3d X_PB = planned.X_PB;
  Eigen::Vector3d p_BF = Eigen::Vector3d::Zero();
  if (has_plan) {
    const Eigen::Vector3d left = planned.X_PL.translation(), right = planned.X_PR.translation();
    p_BF = X_PB.inverse() * (planned.support == Support::left    ? left
                             : planned.support == Support::right ? right
                                                                 : Eigen::Vector3d((left + right) / 2));
  }
  X_PB.translation().head<2>() -= planned.frame_shift;
  const auto place = [&](const Eigen::Isometry3d& X) {
    return FootPose{(X * p_BF).head<2>(), on_floor(X).yaw};
  };
  return {planned.t_s, place(X_PB), place(X_OB)};
}

Steering::Steering(const SteeringOptions& options, const PatternGenerator& plan)
    : options_(options.with_tolerance()) {
  for (std::size_t step = 0; step < plan.steps(); ++step) desired_.push_back(plan.landing(step));
}

bool Steering::is_due(const PatternGenerator& plan, std::size_t tick) const {
  if (stopped_s_ || plan.steps() == 0) return false;
  return plan.is_due() || tick == plan.touch_down(plan.steps() - 1) + kSettlingTicks;
}

void Steering::decide(PatternGenerator& plan, std::size_t tick, const std::optional<PlaceEstimate>& newest) {
  const double now_s = static_cast<double>(tick) * kPeriod;
  if (newest) add(*newest);
  const bool lost = now_s - (newest_ ? newest_->t_s : 0) > options_.lost_s;
  if (plan.free_step() == plan.steps())
    approach_goal(plan);
  else if (lost && options_.on_lost == OnLost::stop)
    stop(plan, now_s);
  else
    correct(plan, now_s);
}

/// X_WP maps the planned sole to the estimated one; its yaw is never wrapped.
void Steering::add(const PlaceEstimate& newest) {
  const double turn = newest.estimated.yaw - newest.planned.yaw - X_WP_.yaw;
  X_WP_.yaw += std::remainder(turn, 2 * std::numbers::pi);
  X_WP_.position = newest.estimated.position - (FootPose{{0, 0}, X_WP_.yaw} * newest.planned).position;
  newest_ = newest;
}

/// The desired pose in the frame of the planned pose.
FootPose Steering::error_of(const FootPose& desired) const {
  return inverse(X_PW_plan_ * desired) * (inverse(X_WP_) * desired);
}

/// Standard deviations of the estimate at a landing in P, along the axes of the landing. They grow with the
/// lever from the sole at which the place was estimated.
Eigen::Vector3d Steering::sigma_at(const FootPose& landing) const {
  if (!newest_) return Eigen::Vector3d::Zero();
  const Eigen::Vector2d lever = (X_WP_ * landing).position - newest_->estimated.position;
  Eigen::Matrix<double, 2, 3> J;
  J << 1, 0, -lever.y(), 0, 1, lever.x();
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(-landing.yaw - X_WP_.yaw).toRotationMatrix();
  const Eigen::Vector2d variance = (R * J * newest_->covariance * J.transpose() * R.transpose()).diagonal();
  return Eigen::Vector3d(variance.x(), variance.y(), newest_->covariance(2, 2)).cwiseMax(0).cwiseSqrt();
}

/// Each part minus its dead band, times the gain, within its limit.
FootPose Steering::limited(const FootPose& error, const Eigen::Vector3d& sigma) const {
  const auto part = [&](double wanted, double sd, double largest) {
    const double beyond = std::max(0.0, std::abs(wanted) - options_.dead_band_sigma * sd);
    return std::clamp(options_.gain * std::copysign(beyond, wanted), -largest, largest);
  };
  return {{part(error.position.x(), sigma.x(), options_.largest_ahead_m),
           part(error.position.y(), sigma.y(), options_.largest_aside_m)},
          part(error.yaw, sigma.z(), options_.largest_turn_rad)};
}

/// The landings starting with `step`, with the corrections so far.
std::vector<Footstep> Steering::planned_from(std::size_t step) const {
  std::vector<Footstep> landings(desired_.begin() + static_cast<std::ptrdiff_t>(step), desired_.end());
  for (Footstep& landing : landings) landing.pose = X_PW_plan_ * landing.pose;
  return landings;
}

void Steering::correct(PatternGenerator& plan, double now_s) {
  const std::size_t step = plan.free_step();
  const bool closes = step + 1 == plan.steps();  // the feet are together at the end
  const FootPose before = X_PW_plan_, desired = desired_[step].pose, uncorrected = before * desired;
  StepCorrection made{step, now_s, desired_[step], X_WP_ * uncorrected, error_of(desired), {}};
  const FootPose wanted = closes || !newest_ ? FootPose{} : limited(made.error, sigma_at(uncorrected));
  const FootPose& standing = plan.stance_before(step).of(other(desired_[step].side));
  const auto outside = [&](const FootPose& pose) {
    return distance_outside(plan.robot(), standing, {desired_[step].side, pose});
  };
  for (const double share : {1.0, 0.5, 0.25, 0.0}) {
    made.correction = {share * wanted.position, share * wanted.yaw};
    const FootPose landing = uncorrected * made.correction;
    X_PW_plan_ = share == 0 ? before : landing * inverse(desired);
    if (share == 0) break;
    // A step that is already outside is not moved farther out.
    if (outside(landing) > outside(uncorrected)) continue;
    if (plan.can_follow(step, planned_from(step))) break;
  }
  plan.replan(step, planned_from(step));
  corrections_.push_back(made);
}

/// The step that is due brings the feet together; its support is already planned.
void Steering::stop(PatternGenerator& plan, double now_s) {
  const std::size_t step = plan.free_step();
  const Side side = desired_[step].side;
  const double aside = side == Side::left ? plan.robot().foot_spacing : -plan.robot().foot_spacing;
  plan.replan(step, {{side, plan.stance_before(step).of(other(side)) * FootPose{{0, aside}, 0}}});
  stopped_s_ = now_s;
}

void Steering::approach_goal(PatternGenerator& plan) {
  Stance end;
  for (const Footstep& step : desired_) end.of(step.side) = step.pose;
  const FootPose error = error_of(center_of(end));
  const bool there =
      error.position.norm() <= options_.tolerance_m && std::abs(error.yaw) <= options_.tolerance_rad;
  if (there || final_steps_ + 2 > options_.final_steps) return;
  const Side first = error.position.y() > 0 ? Side::left : Side::right;
  const std::size_t step = plan.steps();
  for (const Side side : {first, other(first)}) desired_.push_back({side, end.of(side)});
  final_steps_ += 2;
  plan.replan(step, planned_from(step));
}

}  // namespace walking
