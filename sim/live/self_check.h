// The self check: a run is not scored if its ideal sensors disagree with its truth.
#pragma once

#include <optional>
#include <string>

#include "sim/live/inertial_check.h"
#include "sim/live/view_check.h"

namespace sim::live {

/// Largest errors of the ideal sensors of a run.
inline constexpr double kInertialPosition_m = 0.01, kInertialYaw_deg = 0.01, kView_px = 0.3;

/// Given the readings of the ideal sensors and their true poses.
struct SelfCheck {
  InertialCheck inertial;
  std::optional<ViewCheck> view;  ///< absent without a camera

  /// Describes the disagreements; empty if all agree.
  std::string complaint() const;
  /// The figures, for the recording's self_check.json.
  std::string json() const;
};

}  // namespace sim::live
