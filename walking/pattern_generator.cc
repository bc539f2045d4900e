#include "walking/pattern_generator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "walking/preview_control.h"
#include "walking/step_motion.h"
#include "walking/timeline.h"

namespace walking {
namespace {

/// Feet together under the half-sitting robot, with the waist above P's origin.
const FootPose kStart{{hrp2::kAnkleX, 0}, 0};

/// The ZMP is under the center of mass of the half-sitting robot, 4 mm ahead of the ankle. (The
/// original's default is the ankle itself; this way the walk starts and ends in half-sitting exactly.)
const Eigen::Vector2d kZmpInFoot{hrp2::kComInWaist.x() - hrp2::kAnkleX, 0};

}  // namespace

/// The cart-table follows the ZMP reference; waist and feet follow from it and from the footsteps.
struct PatternGenerator::State {
  State(const WalkOptions& walk, const WholeBody& model)
      : options(walk), timeline(walk, kStart, kZmpInFoot), window(static_cast<int>(gains.preview.size())) {
    for (; !window.full(); ++pushed) window.push(smoothed_zmp(timeline, pushed));
    if (options.second_preview && model) second.emplace(model, cart, gains);
  }

  /// The unsmoothed ZMP reference has been used up to and including this tick.
  std::ptrdiff_t used() const { return pushed - 2 + kSmoothingAdvance; }

  /// Returns whether a step may still be changed so many ticks later: it has not lifted off, and the preview
  /// that was used ends before it carries the robot.
  bool is_free(std::size_t step, std::ptrdiff_t ticks_later = 0) const {
    return static_cast<std::ptrdiff_t>(timeline.lift_off(step)) >= tick + ticks_later &&
           static_cast<std::ptrdiff_t>(timeline.touch_down(step)) > used() + ticks_later;
  }

  Reference first_stage();
  void place_feet(const Phase& phase, double elapsed, Reference& reference) const;
  void place_waist(const Phase& phase, double elapsed, Reference& reference) const;

  Reference next() {
    if (!second) return first_stage();
    while (!second->ready()) second->push(first_stage());
    return second->pop();
  }

  WalkOptions options;
  Timeline timeline;
  CartTable cart{options.com_height_m};
  PreviewGains gains = preview_gains(cart, static_cast<int>(std::lround(options.preview_s / kPeriod)));
  PreviewWindow window;  // the smoothed reference
  PreviewControl control{cart, gains, hrp2::kComInWaist.head<2>()};
  std::ptrdiff_t tick = 0, pushed = 0;  // tick: that first_stage() makes
  std::size_t free_step = 0;            // the first step that is_free
  std::optional<SecondPreview> second;
  std::size_t walked = 0;  // ticks that PatternGenerator::next() has made
  Reference last;
};

Reference PatternGenerator::State::first_stage() {
  const auto [phase, tick_of_phase] = timeline.at(tick);
  const double elapsed = static_cast<double>(tick_of_phase) / phase.ticks;
  const PreviewControl::State& x = control.state();
  Reference reference;
  reference.t_s = static_cast<double>(tick) * kPeriod;
  reference.com << x.row(0).transpose(), hrp2::kWaistHeight + hrp2::kComInWaist.z();
  reference.com_velocity << x.row(1).transpose(), 0;
  reference.com_acceleration << x.row(2).transpose(), 0;
  reference.zmp = control.zmp();
  reference.zmp_reference = window.now();
  reference.support = phase.support;
  reference.command = phase.command;
  place_feet(phase, elapsed, reference);
  place_waist(phase, elapsed, reference);
  if (options.arm_motion == ArmMotion::swing) reference.arms = arm_swing(reference);
  control.advance(window);
  window.pop();
  window.push(smoothed_zmp(timeline, pushed++));
  ++tick;
  while (free_step < timeline.steps() && !is_free(free_step)) ++free_step;
  return reference;
}

/// Standing and swinging foot.
void PatternGenerator::State::place_feet(const Phase& phase, double elapsed, Reference& reference) const {
  const auto place = [&](Side side, bool swinging) {
    if (!swinging) return sole(phase.from.of(side));
    return swing_foot(phase.from.of(side), phase.to.of(side), elapsed, options.step_height_m, options.swing);
  };
  reference.X_PL = place(Side::left, phase.support == Support::right);
  reference.X_PR = place(Side::right, phase.support == Support::left);
}

/// The center of mass keeps its place in the waist, which turns in yaw only and stays at its height.
void PatternGenerator::State::place_waist(const Phase& phase, double elapsed, Reference& reference) const {
  const WaistYaw heading = waist_yaw(phase, elapsed);
  reference.X_PB = sole({{0, 0}, heading.yaw});
  const Eigen::Vector3d offset = reference.X_PB.linear() * hrp2::kComInWaist;
  reference.X_PB.translation() = reference.com - offset;
  reference.waist_yaw_rate = heading.rate;
  reference.waist_velocity = reference.com_velocity - heading.rate * Eigen::Vector3d::UnitZ().cross(offset);
}

namespace {

/// First instant of a plan that the legs cannot follow.
struct LegFault {
  int command = 0;
  double t_s = 0;
  std::string obstacle;
};

std::optional<LegFault> leg_fault(PatternGenerator plan) {
  for (std::size_t k = 0; k < plan.ticks(); ++k) {
    const Reference r = plan.next();
    if (const auto obstacle = leg_obstacle(inverse_kinematics(posture_of(r))))
      return LegFault{r.command, r.t_s, *obstacle};
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

/// Returns "; the cause is ..., with ... the legs can follow".
std::string cause_text(const std::string& key, double now, double instead) {
  std::ostringstream text;
  text << "; the cause is walk." << key << " " << now << ", with " << instead << " the legs can follow";
  return text.str();
}

/// Returns the cause if the walk is feasible with the default radius of the arc at that index; else "".
template <class Arc>
std::string radius_cause(WalkOptions options, std::size_t command, const auto& fails) {
  auto* const arc = std::get_if<Arc>(&options.commands[command]);
  if (!arc) return "";
  const double radius_m = std::exchange(arc->radius_m, Arc{}.radius_m);
  if (fails(options)) return "";
  const std::string key = "commands[" + std::to_string(command) + "]." + Arc::kName + ".radius_m";
  return cause_text(key, radius_m, Arc{}.radius_m);
}

}  // namespace

PatternGenerator::PatternGenerator(const WalkOptions& options, const WholeBody& model)
    : PatternGenerator(std::make_unique<State>(options, model)) {
  const auto fault = leg_fault(*this);
  if (!fault) return;
  std::ostringstream text;
  text << "walk.commands[" << fault->command << "]: at " << fault->t_s << " s " << fault->obstacle;
  const auto fails = [&](const WalkOptions& other) {
    return leg_fault(PatternGenerator(std::make_unique<State>(other, model))).has_value();
  };
  std::string cause;
  for (const auto& [key, number] : kNumbers) {
    WalkOptions changed = options;
    changed.*number = WalkOptions{}.*number;
    const bool differs = changed.*number != options.*number;
    if (cause.empty() && differs && !fails(changed))
      cause = cause_text(key, options.*number, changed.*number);
  }
  const auto command = static_cast<std::size_t>(fault->command);
  if (cause.empty()) cause = radius_cause<TangentArc>(options, command, fails);
  if (cause.empty()) cause = radius_cause<PerpendicularArc>(options, command, fails);
  throw std::invalid_argument(text.str() + cause);
}
PatternGenerator::PatternGenerator(std::unique_ptr<State> state) : state_(std::move(state)) {}
PatternGenerator::PatternGenerator(const PatternGenerator& other)
    : state_(std::make_unique<State>(*other.state_)) {}
PatternGenerator::PatternGenerator(PatternGenerator&&) noexcept = default;
PatternGenerator::~PatternGenerator() = default;

std::size_t PatternGenerator::ticks() const { return state_->timeline.ticks(); }

std::size_t PatternGenerator::steps() const { return state_->timeline.steps(); }
Footstep PatternGenerator::landing(std::size_t step) const { return state_->timeline.landing(step); }
std::size_t PatternGenerator::touch_down(std::size_t step) const { return state_->timeline.touch_down(step); }
const Stance& PatternGenerator::stance_before(std::size_t step) const {
  return state_->timeline.stance_before(step);
}
std::size_t PatternGenerator::free_step() const { return state_->free_step; }
bool PatternGenerator::is_due() const { return free_step() < steps() && !state_->is_free(free_step(), 1); }

void PatternGenerator::replan(std::size_t first, const std::vector<Footstep>& landings) {
  if (first < free_step() || first > steps() || (landings.empty() && first != steps()))
    throw std::logic_error("a step that can no longer be changed was planned anew");
  state_->timeline.replan(first, landings, static_cast<std::size_t>(state_->used() + 1));
}

bool PatternGenerator::can_follow(std::size_t first, const std::vector<Footstep>& landings) const {
  constexpr std::size_t kEvery = 4;  // ticks: angles are smooth
  PatternGenerator trial(*this);
  trial.replan(first, landings);
  const std::size_t end = trial.touch_down(std::min(first + 1, trial.steps() - 1));
  for (std::size_t tick = trial.state_->walked; tick < end; ++tick) {
    const Reference reference = trial.next();
    if (tick % kEvery == 0 && leg_obstacle(inverse_kinematics(posture_of(reference)))) return false;
  }
  return true;
}

Reference PatternGenerator::next() {
  State& s = *state_;
  if (s.walked++ < ticks()) return s.last = s.next();
  Reference resting = s.last;
  resting.com_velocity = resting.com_acceleration = resting.waist_velocity = Eigen::Vector3d::Zero();
  resting.waist_yaw_rate = 0;
  return resting;
}

}  // namespace walking
