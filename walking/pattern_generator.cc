#include "walking/pattern_generator.h"

#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "walking/arm_momentum.h"
#include "walking/arm_swing.h"
#include "walking/hrp2.h"
#include "walking/leg_limits.h"
#include "walking/plan_cause.h"
#include "walking/preview_control.h"
#include "walking/second_preview.h"
#include "walking/swing_foot.h"
#include "walking/timeline.h"
#include "walking/waist_yaw.h"
#include "walking/zmp_reference.h"

namespace walking {
namespace {

/// Feet together under the half-sitting robot whose waist is above P's origin.
const FootPose kStart{{hrp2::kAnkleX, 0}, 0};

/// The ZMP is put where the centre of mass of the half-sitting robot is, 4 mm ahead of the ankle. (The
/// original's default is the ankle itself; this way the walk starts and ends in half-sitting exactly.)
const Eigen::Vector2d kZmpInFoot{hrp2::kComInWaist.x() - hrp2::kAnkleX, 0};

Reference at_rest(Reference reference) {
  reference.com_velocity.setZero();
  reference.com_acceleration.setZero();
  reference.waist_velocity.setZero();
  reference.waist_yaw_rate = 0;
  return reference;
}

/// Where the legs cannot follow a plan.
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
  FirstStage(const FirstStage&) = delete;  // zmp_reference_ refers to timeline_

  std::size_t ticks() const { return timeline_.ticks(); }
  Reference next();

 private:
  void place_feet(const Phase& phase, double elapsed, Reference& reference) const;
  void place_waist(const Phase& phase, double elapsed, Reference& reference) const;

  WalkOptions options_;
  Timeline timeline_;
  ZmpReference zmp_reference_;
  PreviewWindow window_;  // the smoothed reference
  PreviewControl control_;
  std::ptrdiff_t tick_ = 0, pushed_ = 0;
};

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
  return reference;
}

/// Both feet where they stand, the swinging one on its way.
void FirstStage::place_feet(const Phase& phase, double elapsed, Reference& reference) const {
  const auto place = [&](Side side, bool swinging) {
    if (!swinging) return sole(phase.from.of(side));
    return swing_foot(phase.from.of(side), phase.to.of(side), elapsed, options_.step_height_m,
                      options_.swing);
  };
  reference.X_PL = place(Side::left, phase.support == Support::right);
  reference.X_PR = place(Side::right, phase.support == Support::left);
}

/// The centre of mass keeps its place in the waist, which turns in yaw only and stays at its height.
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

PatternGenerator::PatternGenerator(const WalkOptions& options, const WholeBody& model) {
  const auto start = [&](const WalkOptions& of) {
    const Timeline timeline(of, kStart, kZmpInFoot);
    const CartTable cart(of.com_height_m);
    const PreviewGains gains = preview_gains(cart, static_cast<int>(std::lround(of.preview_s / kPeriod)));
    return std::make_unique<State>(of, timeline, cart, gains, model);
  };
  const auto is_feasible = [&](const WalkOptions& of) { return !leg_fault(PatternGenerator(start(of))); };
  if (const auto fault = leg_fault(PatternGenerator(start(options))))
    throw std::invalid_argument("walk.commands[" + std::to_string(fault->command) + "]: at " +
                                std::to_string(fault->t_s) + " s " + fault->obstacle + "; " +
                                cause_of_infeasible(options, fault->command, is_feasible));
  state_ = start(options);
}
PatternGenerator::PatternGenerator(std::unique_ptr<State> state) : state_(std::move(state)) {}
PatternGenerator::~PatternGenerator() = default;
PatternGenerator::PatternGenerator(PatternGenerator&&) noexcept = default;

std::size_t PatternGenerator::ticks() const { return state_->first.ticks(); }

Reference PatternGenerator::next() {
  State& s = *state_;
  if (s.tick++ >= ticks()) return at_rest(s.last);
  return s.last = s.next();
}

}  // namespace walking
