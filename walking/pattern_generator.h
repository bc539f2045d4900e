// The paper's section II on one page: footsteps -> ZMP -> preview control -> center of mass, waist and feet.
#pragma once

#include "walking/preview_control.h"
#include "walking/timeline.h"

namespace walking {

/// Plans the whole walk; memory grows with the number of steps, not of ticks. A copy continues from the same
/// tick, independently of the original.
class PatternGenerator {
 public:
  /// Throws std::invalid_argument that names the option or command if the walk cannot be planned (a foot out
  /// of reach, a leg joint beyond its limit). Durations are rounded to whole ticks. Without a model of the
  /// whole body, the second preview stage is left out, and the plan is the cart-table's.
  PatternGenerator(const Robot& robot, const WalkOptions& options, const WholeBody& model = {});

  const Robot& robot() const { return robot_; }

  /// The number of 5 ms ticks of the walk, including the time spent standing at the start and end.
  std::size_t ticks() const { return timeline_.ticks(); }

  /// The next tick's reference; after the last tick, the last reference with zero velocities.
  Reference next();

  /// The steps of the walk, each with its foot, landing (in P) and tick of touch-down.
  std::size_t steps() const { return timeline_.steps(); }
  Footstep landing(std::size_t step) const { return timeline_.landing(step); }
  std::size_t touch_down(std::size_t step) const { return timeline_.touch_down(step); }
  /// Both feet at the start of a step, in P.
  const Stance& stance_before(std::size_t step) const { return timeline_.stance_before(step); }

  /// The first step whose landing can still be changed, or steps() if there is none. A landing is fixed once
  /// its foot lifts off or the ZMP under it enters the preview; with the second preview stage, both happen
  /// one preview earlier.
  std::size_t free_step() const { return free_step_; }
  /// Returns whether this is the last tick that can still change that step.
  bool is_due() const { return free_step_ < steps() && !is_free(free_step_, 1); }
  /// Replans all steps starting with `first` >= free_step(), like Timeline::replan. Feet, ZMP and center of
  /// mass stay continuous, since the part of the preview that was used does not change. Throws
  /// std::logic_error otherwise.
  void replan(std::size_t first, const std::vector<Footstep>& landings);
  /// Returns whether the legs could follow these landings until the step after `first` has landed.
  bool can_follow(std::size_t first, const std::vector<Footstep>& landings) const;

 private:
  struct Unchecked {};
  PatternGenerator(const Robot& robot, const WalkOptions& options, const WholeBody& model,
                   Unchecked);  // legs are not checked

  /// The unsmoothed ZMP reference has been used up to and including this tick.
  std::ptrdiff_t used() const { return pushed_ - 2 + kSmoothingAdvance; }
  bool is_free(std::size_t step, std::ptrdiff_t ticks_later = 0) const;
  Reference first_stage();
  void place_waist(const Phase& phase, double elapsed, Reference& reference) const;

  Robot robot_;
  WalkOptions options_;
  Timeline timeline_;
  CartTable cart_;
  PreviewGains gains_;
  PreviewWindow window_;  // the smoothed reference
  PreviewControl control_;
  std::ptrdiff_t tick_ = 0, pushed_ = 0;  // tick_: the next one of first_stage()
  std::size_t free_step_ = 0;             // the first step that is_free
  std::optional<SecondPreview> second_;
  std::size_t walked_ = 0;  // ticks that next() has returned
  Reference last_;
};

}  // namespace walking
