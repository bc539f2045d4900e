#include "walking/timeline.h"

#include <algorithm>
#include <cmath>

namespace walking {
namespace {

constexpr double kFinalStanding = 2.0;  // s: the center of mass comes to rest as exp(-3.5 t)

int ticks_of(double seconds) { return static_cast<int>(std::lround(seconds / kPeriod)); }

/// The angles of an arm about the y axis in the start posture.
ArmAngles arm_at_start(const Robot& robot, Side side) {
  const Arm& arm = *robot.arms[static_cast<std::size_t>(side)];
  const auto about_y = [&](int joint) {
    return robot.posture[joint] * robot.joints[static_cast<std::size_t>(joint)].axis.y();
  };
  return {about_y(arm.shoulder), about_y(arm.elbow)};
}

double foot_ahead(const Robot& robot, const Eigen::Isometry3d& X_PB, const Eigen::Isometry3d& X_PS) {
  return (X_PB.inverse() * X_PS).translation().x() - robot.sole_ahead;
}

}  // namespace

Timeline::Timeline(const Robot& robot, const WalkOptions& options, const FootPose& start,
                   const Eigen::Vector2d& zmp_in_foot)
    : zmp_in_foot_(zmp_in_foot),
      zmp_inwards_m_(options.zmp_inwards_m),
      stance_(feet_together(start, robot.foot_spacing)),
      waist_yaw_(start.yaw) {
  if (options.commands.empty()) throw std::invalid_argument("walk.commands: the list is empty");
  double_support_ticks_ = ticks_of(options.double_support_s);
  single_support_ticks_ = ticks_of(options.single_support_s);
  stop_ramp_ticks_ = std::max(1, double_support_ticks_ / 2);
  zmp_ = zmp_under(center_of(stance_));
  const int first = ticks_of(options.preview_s) + kSmoothingTicks, last = ticks_of(kFinalStanding);
  const int n = static_cast<int>(options.commands.size());
  if (!std::holds_alternative<Stand>(options.commands.front())) stand(0, first);
  for (int i = 0; i < n; ++i)
    carry_out(robot, i, options, std::max(i == 0 ? first : 0, i + 1 == n ? last : 0));
  if (!std::holds_alternative<Stand>(options.commands.back())) stand(n - 1, last);
}

void Timeline::carry_out(const Robot& robot, int command, const WalkOptions& options,
                         int least_standing) try {
  const Command& what = options.commands[command];
  if (static_cast<std::size_t>(command) == command_begins_.size()) command_begins_.push_back(ticks());
  if (std::holds_alternative<Repeat>(what)) {
    repeat(robot, command, options);
  } else if (const auto* standing = std::get_if<Stand>(&what)) {
    stand(command, std::max(ticks_of(standing->duration_s), least_standing));
  } else {
    const auto steps = footsteps(robot, what, center_of(stance_), options.step_length_m);
    for (const Footstep& landing : steps) step(command, landing);
  }
  if (static_cast<double>(ticks()) * kPeriod > kLongestWalk_s) throw TooLong(command, "");
} catch (const TooLong&) {  // may come from within a repeat
  const auto word = std::visit([](const auto& c) { return c.kName; }, options.commands[command]);
  throw TooLong(command, "walk.commands[" + std::to_string(command) + "]: " + word +
                             ": makes the walk longer than " + std::to_string(kLongestWalk_s) + " s");
} catch (const std::invalid_argument& e) {
  throw std::invalid_argument("walk.commands[" + std::to_string(command) + "]." + e.what());
}

void Timeline::repeat(const Robot& robot, int command, const WalkOptions& options) {
  const Repeat& again = std::get<Repeat>(options.commands[command]);
  const int first = command - again.last;
  if (first < 0)
    throw std::invalid_argument("repeat.last: " + std::to_string(again.last) + " commands, but there are " +
                                std::to_string(command) + " before it");
  for (int i = first; i < command; ++i)
    if (std::holds_alternative<Repeat>(options.commands[i]))
      throw std::invalid_argument("repeat.last: " + std::to_string(again.last) +
                                  " commands, but one of them is itself a repeat");
  laps_.push_back({command_begins_[first], ticks()});
  for (int lap = 0; lap < again.times; ++lap) {
    for (int i = first; i < command; ++i) carry_out(robot, i, options, 0);
    laps_.push_back({laps_.back().end, ticks()});
  }
}

Eigen::Vector2d Timeline::zmp_under(const FootPose& foot) const {
  return (foot * FootPose{zmp_in_foot_, 0}).position;
}

void Timeline::append(Phase phase) {
  if (phase.ticks == 0) return;
  stance_ = phase.to;
  waist_yaw_ = phase.waist_yaw_to;
  zmp_ = phase.zmp_to;
  begins_.push_back(begins_.back() + phase.ticks);
  phases_.push_back(std::move(phase));
}

/// Returns a phase of `ticks` that continues the walk.
Phase Timeline::next_phase(int command, Support support, int ticks) const {
  return {.command = command,
          .support = support,
          .ticks = ticks,
          .from = stance_,
          .to = stance_,
          .waist_yaw_from = waist_yaw_,
          .waist_yaw_to = waist_yaw_,
          .zmp_from = zmp_,
          .zmp_to = zmp_};
}

void Timeline::stand(int command, int ticks) {
  Phase phase = next_phase(command, Support::both, ticks);
  phase.zmp_to = zmp_under(center_of(stance_));
  phase.zmp_ramp_ticks = stop_ramp_ticks_;
  phase.zmp_ramp_start = 1;
  append(std::move(phase));
}

/// A double support in which the ZMP moves to the foot that stays on the ground, then a single support on
/// that foot.
void Timeline::step(int command, const Footstep& step) {
  const Side carrying = other(step.side);
  Phase shift = next_phase(command, Support::both, double_support_ticks_);
  const double inwards = carrying == Side::left ? -zmp_inwards_m_ : zmp_inwards_m_;
  shift.zmp_to = zmp_under(stance_.of(carrying) * FootPose{{0, inwards}, 0});
  shift.zmp_ramp_ticks = shift.ticks;
  append(std::move(shift));
  Phase swing =
      next_phase(command, carrying == Side::left ? Support::left : Support::right, single_support_ticks_);
  swing.to.of(step.side) = step.pose;
  swing.waist_yaw_to = step.pose.yaw;
  swings_.push_back(phases_.size());
  append(std::move(swing));
}

Footstep Timeline::landing(std::size_t step) const {
  const Phase& swing = phases_[swings_[step]];
  const Side side = swing.support == Support::left ? Side::right : Side::left;
  return {side, swing.to.of(side)};
}

/// Keeps only the first `phases` phases.
void Timeline::truncate(std::size_t phases) {
  const Phase& next = phases_[phases];
  stance_ = next.from;
  waist_yaw_ = next.waist_yaw_from;
  zmp_ = next.zmp_from;
  phases_.resize(phases);
  begins_.resize(phases + 1);
  while (!swings_.empty() && swings_.back() >= phases) swings_.pop_back();
}

void Timeline::replan(std::size_t first, const std::vector<Footstep>& landings, std::size_t free) {
  const std::size_t kept = first < steps() ? swings_[first] - 1 : phases_.size() - 1;
  const std::vector<Phase> replaced(phases_.begin() + static_cast<std::ptrdiff_t>(kept), phases_.end());
  const std::size_t standing_from = final_standing();
  Phase standing = replaced.back();
  truncate(kept);
  auto landing = landings.begin();
  for (std::size_t i = 0; i + 1 < replaced.size() && landing != landings.end(); ++i) {
    // A step has two phases; the first is replanned together with the second.
    const bool shifts = replaced[i].support == Support::both && replaced[i + 1].support != Support::both;
    if (replaced[i].support != Support::both)
      step(replaced[i].command, *landing++);
    else if (!shifts)
      stand(replaced[i].command, replaced[i].ticks);
  }
  if (landing != landings.end() && first == steps()) {
    const int begun = std::max(static_cast<int>(free - standing_from), stop_ramp_ticks_);
    stand(standing.command, begun);
    standing.ticks = std::max(standing.ticks - begun, ticks_of(kFinalStanding));
  }
  while (landing != landings.end()) step(standing.command, *landing++);
  stand(standing.command, standing.ticks);
}

Timeline::Moment Timeline::at(std::ptrdiff_t tick) const {
  const auto last = static_cast<std::ptrdiff_t>(ticks()) - 1;
  const auto t = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(tick, 0, last));
  const auto next = std::upper_bound(begins_.begin(), begins_.end(), t);
  const auto i = static_cast<std::size_t>(next - begins_.begin() - 1);
  return {phases_[i], static_cast<int>(t - begins_[i])};
}

std::array<double, kSmoothingTicks + 1> smoothing_weights() {
  std::array<double, kSmoothingTicks + 1> w{};
  for (int i = 1; i < kSmoothingTicks; ++i) {
    const double s = std::sin(std::numbers::pi * i / kSmoothingTicks);
    w[i] = s * s / (kSmoothingTicks / 2.0);  // the squares add up to half the width
  }
  return w;
}

Eigen::Vector2d zmp_reference(const Timeline& timeline, std::ptrdiff_t tick) {
  const auto [phase, tick_of_phase] = timeline.at(tick);
  const double s =
      std::min(1.0, static_cast<double>(tick_of_phase + phase.zmp_ramp_start) / phase.zmp_ramp_ticks);
  return phase.zmp_from + s * (phase.zmp_to - phase.zmp_from);
}

Eigen::Vector2d smoothed_zmp(const Timeline& timeline, std::ptrdiff_t tick) {
  static const auto weights = smoothing_weights();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int j = 1; j < kSmoothingTicks; ++j)
    sum += weights[j] * zmp_reference(timeline, tick - j + kSmoothingAdvance);
  return sum;
}

Eigen::Isometry3d sole(const FootPose& foot, double height_m) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear().topLeftCorner<2, 2>() = Eigen::Rotation2Dd(foot.yaw).toRotationMatrix();
  X.translation() << foot.position, height_m;
  return X;
}

FootPose on_floor(const Eigen::Isometry3d& X) {
  return {X.translation().head<2>(), std::atan2(X(1, 0), X(0, 0))};
}

Eigen::Isometry3d swing_foot(const FootPose& from, const FootPose& to, double elapsed, double step_height_m,
                             SwingPolynomial polynomial) {
  constexpr double kMargin = 0.05;  // fraction of single support with vertical motion, at either end
  const double s = std::clamp((elapsed - kMargin) / (1 - 2 * kMargin), 0.0, 1.0);
  const double along = polynomial == SwingPolynomial::quintic ? quintic_blend(s) : cubic_blend(s);
  const double up = elapsed * (1 - elapsed);
  const FootPose foot{from.position + along * (to.position - from.position),
                      from.yaw + cubic_blend(s) * (to.yaw - from.yaw)};
  return sole(foot, 16 * step_height_m * up * up);
}

WaistYaw waist_yaw(const Phase& phase, double elapsed) {
  const double turn = phase.waist_yaw_to - phase.waist_yaw_from;
  return {phase.waist_yaw_from + turn * cubic_blend(elapsed),
          turn * (6 * elapsed * (1 - elapsed)) / (phase.ticks * kPeriod)};
}

ArmAngles arm_swing(const Robot& robot, Side side, double foot_ahead_m) {
  const double segment = robot.upper_arm;
  const auto [shoulder, elbow_at_start] = arm_at_start(robot, side);
  const double z = segment * (std::cos(shoulder) + std::cos(shoulder + elbow_at_start)),
               x_at_start = -segment * (std::sin(shoulder) + std::sin(shoulder + elbow_at_start));
  // Half of the straight arm's forward reach at that height, per 0.2 m of distance of the foot.
  const double gain = 0.5 * std::sqrt(segment * segment - std::pow(z - segment, 2)) / 0.2;
  const double x = x_at_start - gain * foot_ahead_m;
  const double distance = std::min(std::hypot(x, z), 2 * segment);
  const double elbow = std::acos(1 - distance * distance / (2 * segment * segment)) - std::numbers::pi;
  const double at_shoulder = std::asin(segment * std::sin(std::numbers::pi + elbow) / distance);
  return {at_shoulder - std::atan2(x, z), elbow};
}

Arms arm_swing(const Robot& robot, const Reference& reference) {
  return {arm_swing(robot, Side::right, foot_ahead(robot, reference.X_PB, reference.X_PR)),
          arm_swing(robot, Side::left, foot_ahead(robot, reference.X_PB, reference.X_PL))};
}

}  // namespace walking
