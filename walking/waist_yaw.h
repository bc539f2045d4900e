// The heading of the waist: turns with the swinging foot, at rest whenever both feet are down.
#pragma once

#include "walking/timeline.h"

namespace walking {

struct WaistYaw {
  double yaw = 0;   ///< rad, never wrapped
  double rate = 0;  ///< rad/s
};

/// Cubic from the heading at the phase's begin to that at its end, `elapsed` in 0 ... 1 of the phase (Stasse
/// et al. 2006, section II: the waist turns in yaw only, on a third-order polynomial).
WaistYaw waist_yaw(const Phase& phase, double elapsed);

}  // namespace walking
