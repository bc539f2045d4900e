// The paper's section II on one page: footsteps -> ZMP -> preview control -> centre of mass, waist and feet.
#pragma once

#include <cstddef>
#include <memory>

#include "walking/plan.h"
#include "walking/whole_body.h"

namespace walking {

/// Plans the whole walk. Streaming: memory grows with the number of steps, not of ticks.
class PatternGenerator {
 public:
  /// Throws std::invalid_argument naming the option or command when the walk cannot be planned (a value out
  /// of range, a foot out of reach, a leg joint beyond its limit). Durations are rounded to whole ticks.
  /// The second preview stage and arms that compensate yaw momentum need a model of the whole body; without
  /// one the plan is the cart-table's, with still arms.
  explicit PatternGenerator(const WalkOptions& options, const WholeBody& model = {});
  ~PatternGenerator();
  PatternGenerator(PatternGenerator&&) noexcept;

  /// The number of 5 ms ticks of the walk, first and last standing included.
  std::size_t ticks() const;

  /// The next tick's reference; after the last tick, the last reference with zero velocities.
  Reference next();

 private:
  struct State;
  explicit PatternGenerator(std::unique_ptr<State> state);  // without the check of the legs
  std::unique_ptr<State> state_;
};

}  // namespace walking
