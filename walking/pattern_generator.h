// The paper's section II on one page: footsteps -> ZMP -> preview control -> center of mass, waist and feet.
#pragma once

#include <memory>

#include "walking/footsteps.h"
#include "walking/kinematics.h"

namespace walking {

/// Plans the whole walk. Streaming: memory grows with the number of steps, not of ticks.
class PatternGenerator {
 public:
  /// Throws std::invalid_argument naming the option or command when the walk cannot be planned (a value out
  /// of range, a foot out of reach, a leg joint beyond its limit). Durations are rounded to whole ticks.
  /// The second preview stage needs a model of the whole body; without one the plan is the cart-table's.
  explicit PatternGenerator(const WalkOptions& options, const WholeBody& model = {});
  /// Plays the checked plan from the same tick, independently of the other.
  PatternGenerator(const PatternGenerator& other);
  PatternGenerator(PatternGenerator&&) noexcept;
  ~PatternGenerator();

  /// The number of 5 ms ticks of the walk, first and last standing included.
  std::size_t ticks() const;

  /// The next tick's reference; after the last tick, the last reference with zero velocities.
  Reference next();

  /// The steps of the walk: each with its foot, landing (in P) and tick of touch-down.
  std::size_t steps() const;
  Footstep landing(std::size_t step) const;
  std::size_t touch_down(std::size_t step) const;
  /// Both feet at the start of a step, in P.
  const Stance& stance_before(std::size_t step) const;

  /// The first step with a landing that can still be changed; steps() if none can. A landing can be changed
  /// until its foot lifts off or the ZMP under it, once it carries, comes into the preview. With the second
  /// preview stage both are a preview earlier.
  std::size_t free_step() const;
  /// Returns whether this is the last tick at which that step can be changed.
  bool is_due() const;
  /// Plans all steps from `first` >= free_step() on anew, as Timeline::replan; feet, ZMP and center of mass
  /// stay continuous, since no part of the preview that was used changes. Throws std::logic_error otherwise.
  void replan(std::size_t first, const std::vector<Footstep>& landings);
  /// Returns whether the legs could follow these landings until the step after `first` has landed.
  bool can_follow(std::size_t first, const std::vector<Footstep>& landings) const;

 private:
  struct State;
  explicit PatternGenerator(std::unique_ptr<State> state);  // without the check of the legs
  std::unique_ptr<State> state_;
};

}  // namespace walking
