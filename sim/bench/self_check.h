// The bench's doubt of itself: a run whose senses do not agree with its truth is not scored.
#pragma once

#include <optional>
#include <string>

#include "sim/bench/inertial_check.h"
#include "sim/bench/view_check.h"

namespace sim::bench {

/// What the ideal sensors of a run may be off, at most.
inline constexpr double kInertialPosition_m = 0.01, kInertialYaw_deg = 0.01, kView_px = 0.3;

/// Fed with what the ideal sensors gave and where they truly were.
struct SelfCheck {
  InertialCheck inertial;
  std::optional<ViewCheck> view;  ///< absent without a camera

  /// What does not agree; empty if all does.
  std::string complaint() const;
  /// The figures, for the recording's self_check.json.
  std::string json() const;
};

}  // namespace sim::bench
