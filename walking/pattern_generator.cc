#include "walking/pattern_generator.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "walking/arms.h"
#include "walking/hrp2.h"
#include "walking/kinematics.h"
#include "walking/plan_cause.h"
#include "walking/preview_control.h"
#include "walking/second_preview.h"
#include "walking/swing_foot.h"
#include "walking/timeline.h"

namespace walking {
namespace {

/// Feet together under the half-sitting robot, with the waist above P's origin.
const FootPose kStart{{hrp2::kAnkleX, 0}, 0};

/// The ZMP is under the center of mass of the half-sitting robot, 4 mm ahead of the ankle. (The
/// original's default is the ankle itself; this way the walk starts and ends in half-sitting exactly.)
const Eigen::Vector2d kZmpInFoot{hrp2::kComInWaist.x() - hrp2::kAnkleX, 0};

Reference at_rest(Reference reference) {
  reference.com_velocity.setZero();
  reference.com_acceleration.setZero();
  reference.waist_velocity.setZero();
  reference.waist_yaw_rate = 0;
  return reference;
}

/// First instant of a plan that the legs cannot follow.
struct LegFault {
  int command = 0;
  double t_s = 0;
  std::string obstacle;
};

/// Plays the plan up to its first instant that is beyond the legs.
std::optional<LegFault> leg_fault(PatternGenerator plan) {
  for (std::size_t k = 0; k < plan.ticks(); ++k) {
    const Reference r = plan.next();
    if (const auto obstacle = leg_obstacle(inverse_kinematics(posture_of(r))))
      return LegFault{r.command, r.t_s, *obstacle};
  }
  return std::nullopt;
}

/// The cart-table follows the ZMP reference; waist and feet follow from it and from the footsteps.
class FirstStage {
 public:
  FirstStage(const WalkOptions& options, const Timeline& timeline, const CartTable& cart,
             const PreviewGains& gains)
      : options_(options),
        timeline_(timeline),
        zmp_reference_(timeline_),
        window_(static_cast<int>(gains.preview.size())),
        control_(cart, gains, hrp2::kComInWaist.head<2>()) {
    for (; !window_.full(); ++pushed_) window_.push(zmp_reference_.smoothed(pushed_));
  }
  FirstStage(const FirstStage& other)
      : options_(other.options_),
        timeline_(other.timeline_),
        zmp_reference_(timeline_),  // refers to the copy's own
        window_(other.window_),
        control_(other.control_),
        tick_(other.tick_),
        pushed_(other.pushed_),
        free_step_(other.free_step_) {}
  FirstStage& operator=(const FirstStage&) = delete;

  const Timeline& timeline() const { return timeline_; }
  Reference next();

  /// The tick that next() makes.
  std::ptrdiff_t tick() const { return tick_; }
  /// The first step that may still be changed: it has not lifted off, and the preview that was used ends
  /// before it carries the robot.
  std::size_t free_step() const { return free_step_; }
  bool is_due() const;
  void replan(std::size_t first, const std::vector<Footstep>& landings);

 private:
  /// The unsmoothed ZMP reference has been used up to and including this tick.
  std::ptrdiff_t used() const { return pushed_ - 2 + kSmoothingAdvance; }
  bool is_free(std::size_t step, std::ptrdiff_t ticks_later = 0) const;
  void place_feet(const Phase& phase, double elapsed, Reference& reference) const;
  void place_waist(const Phase& phase, double elapsed, Reference& reference) const;

  WalkOptions options_;
  Timeline timeline_;
  ZmpReference zmp_reference_;
  PreviewWindow window_;  // the smoothed reference
  PreviewControl control_;
  std::ptrdiff_t tick_ = 0, pushed_ = 0;
  std::size_t free_step_ = 0;
};

bool FirstStage::is_free(std::size_t step, std::ptrdiff_t ticks_later) const {
  return static_cast<std::ptrdiff_t>(timeline_.lift_off(step)) >= tick_ + ticks_later &&
         static_cast<std::ptrdiff_t>(timeline_.touch_down(step)) > used() + ticks_later;
}

bool FirstStage::is_due() const { return free_step_ < timeline_.steps() && !is_free(free_step_, 1); }

void FirstStage::replan(std::size_t first, const std::vector<Footstep>& landings) {
  if (first < free_step_ || first > timeline_.steps() || (landings.empty() && first != timeline_.steps()))
    throw std::logic_error("a step that can no longer be changed was planned anew");
  timeline_.replan(first, landings, static_cast<std::size_t>(used() + 1));
}

Reference FirstStage::next() {
  const auto [phase, tick_of_phase] = timeline_.at(tick_);
  const double elapsed = static_cast<double>(tick_of_phase) / phase.ticks;
  const PreviewControl::State& x = control_.state();
  Reference reference;
  reference.t_s = static_cast<double>(tick_) * kPeriod;
  reference.com << x.row(0).transpose(), hrp2::kWaistHeight + hrp2::kComInWaist.z();
  reference.com_velocity << x.row(1).transpose(), 0;
  reference.com_acceleration << x.row(2).transpose(), 0;
  reference.zmp = control_.zmp();
  reference.zmp_reference = window_.now();
  reference.support = phase.support;
  reference.command = phase.command;
  place_feet(phase, elapsed, reference);
  place_waist(phase, elapsed, reference);
  control_.advance(window_);
  window_.pop();
  window_.push(zmp_reference_.smoothed(pushed_++));
  ++tick_;
  while (free_step_ < timeline_.steps() && !is_free(free_step_)) ++free_step_;
  return reference;
}

/// Standing and swinging foot.
void FirstStage::place_feet(const Phase& phase, double elapsed, Reference& reference) const {
  const auto place = [&](Side side, bool swinging) {
    if (!swinging) return sole(phase.from.of(side));
    return swing_foot(phase.from.of(side), phase.to.of(side), elapsed, options_.step_height_m,
                      options_.swing);
  };
  reference.X_PL = place(Side::left, phase.support == Support::right);
  reference.X_PR = place(Side::right, phase.support == Support::left);
}

/// The center of mass keeps its place in the waist, which turns in yaw only and stays at its height.
void FirstStage::place_waist(const Phase& phase, double elapsed, Reference& reference) const {
  const WaistYaw heading = waist_yaw(phase, elapsed);
  reference.X_PB = sole({{0, 0}, heading.yaw});
  const Eigen::Vector3d offset = reference.X_PB.linear() * hrp2::kComInWaist;
  reference.X_PB.translation() = reference.com - offset;
  reference.waist_yaw_rate = heading.rate;
  reference.waist_velocity = reference.com_velocity - heading.rate * Eigen::Vector3d::UnitZ().cross(offset);
}

}  // namespace

struct PatternGenerator::State {
  State(const WalkOptions& options, const WholeBody& model)
      : State(options, CartTable(options.com_height_m), model) {}
  State(const WalkOptions& options, const CartTable& cart, const WholeBody& model)
      : State(options, Timeline(options, kStart, kZmpInFoot), cart,
              preview_gains(cart, static_cast<int>(std::lround(options.preview_s / kPeriod))), model) {}
  State(const WalkOptions& options, const Timeline& timeline, const CartTable& cart,
        const PreviewGains& gains, const WholeBody& model)
      : first(options, timeline, cart, gains) {
    if (options.arm_motion == ArmMotion::swing) arms = [](const Reference& r) { return arm_swing(r); };
    if (options.arm_motion == ArmMotion::momentum && model) arms = ArmMomentum(model);
    if (options.second_preview && model) second.emplace(model, cart, gains);
  }

  Reference first_stage() {
    Reference reference = first.next();
    if (arms) reference.arms = arms(reference);
    return reference;
  }

  Reference next() {
    if (!second) return first_stage();
    while (!second->ready()) second->push(first_stage());
    return second->pop();
  }

  FirstStage first;
  std::function<Arms(const Reference&)> arms;  // none: half-sitting
  std::optional<SecondPreview> second;
  std::size_t tick = 0;
  Reference last;
};

PatternGenerator::PatternGenerator(const WalkOptions& options, const WholeBody& model)
    : PatternGenerator(std::make_unique<State>(options, model)) {
  const auto fault = leg_fault(*this);
  if (!fault) return;
  const auto is_feasible = [&](const WalkOptions& of) {
    return !leg_fault(PatternGenerator(std::make_unique<State>(of, model)));
  };
  throw std::invalid_argument("walk.commands[" + std::to_string(fault->command) + "]: at " +
                              std::to_string(fault->t_s) + " s " + fault->obstacle + "; " +
                              cause_of_infeasible(options, fault->command, is_feasible));
}
PatternGenerator::PatternGenerator(std::unique_ptr<State> state) : state_(std::move(state)) {}
PatternGenerator::PatternGenerator(const PatternGenerator& other)
    : state_(std::make_unique<State>(*other.state_)) {}
PatternGenerator::PatternGenerator(PatternGenerator&&) noexcept = default;
PatternGenerator::~PatternGenerator() = default;

std::size_t PatternGenerator::ticks() const { return state_->first.timeline().ticks(); }

std::size_t PatternGenerator::steps() const { return state_->first.timeline().steps(); }
Footstep PatternGenerator::landing(std::size_t step) const { return state_->first.timeline().landing(step); }
std::size_t PatternGenerator::touch_down(std::size_t step) const {
  return state_->first.timeline().touch_down(step);
}
const Stance& PatternGenerator::stance_before(std::size_t step) const {
  return state_->first.timeline().stance_before(step);
}
std::size_t PatternGenerator::free_step() const { return state_->first.free_step(); }
bool PatternGenerator::is_due() const { return state_->first.is_due(); }

void PatternGenerator::replan(std::size_t first, const std::vector<Footstep>& landings) {
  state_->first.replan(first, landings);
}

bool PatternGenerator::can_follow(std::size_t first, const std::vector<Footstep>& landings) const {
  constexpr std::size_t kEvery = 4;  // ticks: angles are smooth
  PatternGenerator trial(*this);
  trial.replan(first, landings);
  const std::size_t end = trial.touch_down(std::min(first + 1, trial.steps() - 1));
  for (std::size_t tick = trial.state_->tick; tick < end; ++tick) {
    const Reference reference = trial.next();
    if (tick % kEvery == 0 && leg_obstacle(inverse_kinematics(posture_of(reference)))) return false;
  }
  return true;
}

Reference PatternGenerator::next() {
  State& s = *state_;
  if (s.tick++ >= ticks()) return at_rest(s.last);
  return s.last = s.next();
}

}  // namespace walking
