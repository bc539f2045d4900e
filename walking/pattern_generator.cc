#include "walking/pattern_generator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

namespace walking {
namespace {

/// The feet together under the robot in its start posture, with the waist above P's origin.
FootPose start_of(const Robot& robot) { return {{robot.sole_ahead, 0}, 0}; }

/// The ZMP is under the center of mass of the robot in the start posture, a few mm ahead of the ankle, so
/// that the walk starts and ends exactly in the start posture. (The JRL pattern generator uses the ankle
/// itself by default.)
Eigen::Vector2d zmp_in_foot(const Robot& robot) { return {robot.com.x() - robot.sole_ahead, 0}; }

/// The first instant at which the legs cannot follow a plan.
struct LegFault {
  int command = 0;
  double t_s = 0;
  std::string obstacle;
};

std::optional<LegFault> leg_fault(PatternGenerator plan) {
  const Robot& robot = plan.robot();
  JointVector q = robot.posture;
  for (std::size_t k = 0; k < plan.ticks(); ++k) {
    const Reference r = plan.next();
    const BodySolution body = inverse_kinematics(robot, r, q);
    q = body.q;
    if (const auto obstacle = leg_obstacle(robot, body)) return LegFault{r.command, r.t_s, *obstacle};
  }
  return std::nullopt;
}

constexpr std::array<std::pair<const char*, double WalkOptions::*>, 6> kNumbers{
    {{"single_support_s", &WalkOptions::single_support_s},
     {"double_support_s", &WalkOptions::double_support_s},
     {"step_height_m", &WalkOptions::step_height_m},
     {"step_length_m", &WalkOptions::step_length_m},
     {"preview_s", &WalkOptions::preview_s},
     {"com_height_m", &WalkOptions::com_height_m}}};

/// Returns "; the cause is ...; with ..., the legs can follow".
std::string cause_text(const std::string& key, double now, double instead) {
  std::ostringstream text;
  text << "; the cause is walk." << key << " " << now << "; with " << instead << ", the legs can follow";
  return text.str();
}

/// If the default radius of the arc at that index makes the walk feasible, returns that as the cause.
template <class Arc>
std::optional<std::string> radius_cause(WalkOptions options, std::size_t command, const auto& fails) {
  auto* const arc = std::get_if<Arc>(&options.commands[command]);
  if (!arc) return std::nullopt;
  const double radius_m = std::exchange(arc->radius_m, Arc{}.radius_m);
  if (fails(options)) return std::nullopt;
  const std::string key = "commands[" + std::to_string(command) + "]." + Arc::kName + ".radius_m";
  return cause_text(key, radius_m, Arc{}.radius_m);
}

}  // namespace

PatternGenerator::PatternGenerator(const Robot& robot, const WalkOptions& options, const WholeBody& model,
                                   Unchecked)
    : robot_(robot),
      options_(options),
      timeline_(robot, options, start_of(robot), zmp_in_foot(robot)),
      cart_(options.com_height_m > 0 ? options.com_height_m : robot.com_height()),
      gains_(preview_gains(cart_, static_cast<int>(std::lround(options.preview_s / kPeriod)))),
      window_(static_cast<int>(gains_.preview.size())),
      control_(cart_, gains_, robot.com.head<2>()) {
  for (const Leg& leg : robot.legs)
    if (leg.joints.size() != 6)
      throw std::invalid_argument("walk.controller: the built-in controller needs legs of 6 joints, found " +
                                  std::to_string(leg.joints.size()) + "; expected {program: [...]}");
  if (options.arm_motion == ArmMotion::swing && !(robot.arms[0] && robot.arms[1]))
    throw std::invalid_argument("walk.arm_motion: swing: the robot has no arms that swing, expected still");
  for (; !window_.full(); ++pushed_) window_.push(smoothed_zmp(timeline_, pushed_));
  if (options.second_preview && model) second_.emplace(robot, model, cart_, gains_);
}

PatternGenerator::PatternGenerator(const Robot& robot, const WalkOptions& options, const WholeBody& model)
    : PatternGenerator(robot, options, model, Unchecked()) {
  const auto fault = leg_fault(*this);
  if (!fault) return;
  std::ostringstream text;
  text << "walk.commands[" << fault->command << "]: at " << fault->t_s << " s " << fault->obstacle;
  const auto fails = [&](const WalkOptions& other) {
    return leg_fault(PatternGenerator(robot, other, model, Unchecked())).has_value();
  };
  std::optional<std::string> cause;
  WalkOptions usual;
  usual.com_height_m = robot.com_height();
  for (const auto& [key, number] : kNumbers) {
    WalkOptions changed = options;
    changed.*number = usual.*number;
    const bool differs = changed.*number != options.*number;
    if (!cause && differs && !fails(changed)) cause = cause_text(key, options.*number, changed.*number);
  }
  const auto command = static_cast<std::size_t>(fault->command);
  if (!cause) cause = radius_cause<TangentArc>(options, command, fails);
  if (!cause) cause = radius_cause<PerpendicularArc>(options, command, fails);
  for (const auto& [key, number] : {kNumbers[3], kNumbers[2]})  // shorter steps, then lower ones
    for (const double part : {0.75, 0.5, 0.25}) {
      WalkOptions changed = options;
      changed.*number *= part;
      if (!cause && !fails(changed)) cause = cause_text(key, options.*number, changed.*number);
    }
  throw std::invalid_argument(text.str() + cause.value_or(""));
}

/// Returns whether a step may still be changed ticks_later from now: it has not lifted off, and the part of
/// the preview that was used ends before the foot carries the robot.
bool PatternGenerator::is_free(std::size_t step, std::ptrdiff_t ticks_later) const {
  return static_cast<std::ptrdiff_t>(timeline_.lift_off(step)) >= tick_ + ticks_later &&
         static_cast<std::ptrdiff_t>(timeline_.touch_down(step)) > used() + ticks_later;
}

/// The cart-table follows the ZMP reference; the waist and feet follow from the cart-table and from the
/// footsteps.
Reference PatternGenerator::first_stage() {
  const auto [phase, tick_of_phase] = timeline_.at(tick_);
  const double elapsed = static_cast<double>(tick_of_phase) / phase.ticks;
  const PreviewControl::State& x = control_.state();
  Reference reference;
  reference.t_s = static_cast<double>(tick_) * kPeriod;
  reference.com << x.row(0).transpose(), robot_.com_height();
  reference.com_velocity << x.row(1).transpose(), 0;
  reference.com_acceleration << x.row(2).transpose(), 0;
  reference.zmp = control_.zmp();
  reference.zmp_reference = window_.now();
  reference.support = phase.support;
  reference.command = phase.command;
  const auto foot = [&, &p = phase](Side side, bool swinging) {
    if (!swinging) return sole(p.from.of(side));
    return swing_foot(p.from.of(side), p.to.of(side), elapsed, options_.step_height_m, options_.swing);
  };
  reference.X_PL = foot(Side::left, phase.support == Support::right);
  reference.X_PR = foot(Side::right, phase.support == Support::left);
  place_waist(phase, elapsed, reference);
  if (phase.support != Support::both) {
    const Side side = phase.support == Support::left ? Side::right : Side::left;
    reference.swing = {side, sole(phase.to.of(side)), elapsed, (phase.ticks - tick_of_phase) * kPeriod};
  }
  if (options_.arm_motion == ArmMotion::swing) reference.arms = arm_swing(robot_, reference);
  control_.advance(window_);
  window_.pop();
  window_.push(smoothed_zmp(timeline_, pushed_++));
  ++tick_;
  while (free_step_ < timeline_.steps() && !is_free(free_step_)) ++free_step_;
  return reference;
}

/// The center of mass keeps its place relative to the waist, which turns in yaw only and stays at its height.
void PatternGenerator::place_waist(const Phase& phase, double elapsed, Reference& reference) const {
  const WaistYaw heading = waist_yaw(phase, elapsed);
  reference.X_PB = sole({{0, 0}, heading.yaw});
  const Eigen::Vector3d offset = reference.X_PB.linear() * robot_.com;
  reference.X_PB.translation() = reference.com - offset;
  reference.waist_yaw_rate = heading.rate;
  reference.waist_velocity = reference.com_velocity - heading.rate * Eigen::Vector3d::UnitZ().cross(offset);
}

void PatternGenerator::replan(std::size_t first, const std::vector<Footstep>& landings) {
  if (first < free_step() || first > steps() || (landings.empty() && first != steps()))
    throw std::logic_error("cannot replan a step that is no longer free");
  timeline_.replan(first, landings, static_cast<std::size_t>(used() + 1));
}

bool PatternGenerator::can_follow(std::size_t first, const std::vector<Footstep>& landings) const {
  constexpr std::size_t kEvery = 4;  // checks only every 4th tick, since the angles are smooth
  PatternGenerator trial(*this);
  JointVector q = robot_.posture;
  trial.replan(first, landings);
  const std::size_t end = trial.touch_down(std::min(first + 1, trial.steps() - 1));
  for (std::size_t tick = trial.walked_; tick < end; ++tick) {
    const Reference reference = trial.next();
    if (tick % kEvery != 0) continue;
    const BodySolution body = inverse_kinematics(robot_, reference, q);
    if (leg_obstacle(robot_, body)) return false;
    q = body.q;
  }
  return true;
}

Reference PatternGenerator::next() {
  if (walked_++ < ticks()) {
    if (!second_) return last_ = first_stage();
    while (!second_->ready()) second_->push(first_stage());
    return last_ = second_->pop();
  }
  Reference resting = last_;
  resting.com_velocity = resting.com_acceleration = resting.waist_velocity = Eigen::Vector3d::Zero();
  resting.waist_yaw_rate = 0;
  return resting;
}

}  // namespace walking
