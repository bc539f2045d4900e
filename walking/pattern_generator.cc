#include "walking/pattern_generator.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "walking/hrp2.h"
#include "walking/leg_limits.h"
#include "walking/preview_control.h"
#include "walking/swing_foot.h"
#include "walking/timeline.h"
#include "walking/waist_yaw.h"
#include "walking/zmp_reference.h"

namespace walking {
namespace {

/// Feet together under the half-sitting robot whose waist is above P's origin.
const FootPose kStart{{hrp2::kAnkleX, 0}, 0};

/// The ZMP shall be where the centre of mass of the half-sitting robot is: 4 mm ahead of the ankle. (The
/// original's default is the ankle itself; this way the walk starts and ends in half-sitting exactly.)
const Eigen::Vector2d kZmpInFoot{hrp2::kComInWaist.x() - hrp2::kAnkleX, 0};

int horizon_of(const WalkOptions& options) {
  return static_cast<int>(std::lround(options.preview_s / kPeriod));
}

Reference at_rest(Reference reference) {
  reference.com_velocity.setZero();
  reference.com_acceleration.setZero();
  reference.waist_velocity.setZero();
  reference.waist_yaw_rate = 0;
  return reference;
}

/// Walks the whole plan in thought. Throws std::invalid_argument where the legs cannot follow.
void require_legs_to_follow(PatternGenerator plan) {
  for (std::size_t k = 0; k < plan.ticks(); ++k) {
    const Reference r = plan.next();
    const auto obstacle = legs_prevent(inverse_kinematics({r.X_PB, r.X_PL, r.X_PR}));
    if (!obstacle) continue;
    throw std::invalid_argument("walk.commands[" + std::to_string(r.command) + "]: at " +
                                std::to_string(r.t_s) + " s " + *obstacle + "; shorten walk.step_length_m");
  }
}

}  // namespace

struct PatternGenerator::State {
  explicit State(const WalkOptions& walk)
      : options(walk),
        timeline(walk, kStart, kZmpInFoot),
        zmp_reference(timeline),
        window(horizon_of(walk) + 1, 2),
        control(CartTable(walk.com_height_m), preview_gains(CartTable(walk.com_height_m), horizon_of(walk)),
                hrp2::kComInWaist.head<2>()) {
    for (int j = 0; j < window.rows(); ++j) window.row(j) = zmp_reference.smoothed(j);
  }

  Reference now() const;
  void advance();
  void place_feet(const Phase& phase, double elapsed, Reference& reference) const;
  void place_waist(const Phase& phase, double elapsed, Reference& reference) const;

  WalkOptions options;
  Timeline timeline;
  ZmpReference zmp_reference;
  Eigen::MatrixX2d window;  // the smoothed reference of this tick and of the preview's
  PreviewControl control;
  std::size_t tick = 0;
  Reference last;
};

Reference PatternGenerator::State::now() const {
  const auto [phase, tick_of_phase] = timeline.at(static_cast<std::ptrdiff_t>(tick));
  const double elapsed = static_cast<double>(tick_of_phase) / phase.ticks;
  const PreviewControl::State& x = control.state();
  Reference reference;
  reference.t_s = static_cast<double>(tick) * kPeriod;
  reference.com << x.row(0).transpose(), hrp2::kWaistHeight + hrp2::kComInWaist.z();
  reference.com_velocity << x.row(1).transpose(), 0;
  reference.com_acceleration << x.row(2).transpose(), 0;
  reference.zmp = control.zmp();
  reference.zmp_reference = window.row(0);
  reference.support = phase.support;
  reference.command = phase.command;
  place_feet(phase, elapsed, reference);
  place_waist(phase, elapsed, reference);
  return reference;
}

/// Both feet where they stand, the swinging one on its way.
void PatternGenerator::State::place_feet(const Phase& phase, double elapsed, Reference& reference) const {
  const auto place = [&](Side side, bool swinging) {
    if (!swinging) return sole(phase.from.of(side));
    return swing_foot(phase.from.of(side), phase.to.of(side), elapsed, options.step_height_m, options.swing);
  };
  reference.X_PL = place(Side::left, phase.support == Support::right);
  reference.X_PR = place(Side::right, phase.support == Support::left);
}

/// The centre of mass keeps its place in the waist, which turns in yaw only and stays at its height.
void PatternGenerator::State::place_waist(const Phase& phase, double elapsed, Reference& reference) const {
  const WaistYaw heading = waist_yaw(phase, elapsed);
  reference.X_PB = sole({{0, 0}, heading.yaw});
  const Eigen::Vector3d offset = reference.X_PB.linear() * hrp2::kComInWaist;
  reference.X_PB.translation() = reference.com - offset;
  reference.waist_yaw_rate = heading.rate;
  reference.waist_velocity = reference.com_velocity - heading.rate * Eigen::Vector3d::UnitZ().cross(offset);
}

/// Preview control moves the centre of mass on; the window moves with it.
void PatternGenerator::State::advance() {
  const Eigen::Index n = window.rows();
  control.advance(window.row(0).transpose(), window.bottomRows(n - 1));
  window.topRows(n - 1) = window.bottomRows(n - 1).eval();
  ++tick;
  window.row(n - 1) = zmp_reference.smoothed(static_cast<std::ptrdiff_t>(tick) + n - 1);
}

PatternGenerator::PatternGenerator(const WalkOptions& options) : state_(std::make_unique<State>(options)) {
  require_legs_to_follow(PatternGenerator(std::make_unique<State>(options)));
}
PatternGenerator::PatternGenerator(std::unique_ptr<State> state) : state_(std::move(state)) {}
PatternGenerator::~PatternGenerator() = default;
PatternGenerator::PatternGenerator(PatternGenerator&&) noexcept = default;

std::size_t PatternGenerator::ticks() const { return state_->timeline.ticks(); }

Reference PatternGenerator::next() {
  State& s = *state_;
  if (s.tick >= ticks()) return at_rest(s.last);
  s.last = s.now();
  s.advance();
  return s.last;
}

}  // namespace walking
