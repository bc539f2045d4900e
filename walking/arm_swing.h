// The arms swing against the legs, so that their yaw momentum makes up for part of that of the legs.
#pragma once

#include "walking/plan.h"

namespace walking {

/// The arm while the foot on its side is `foot_ahead_m` ahead of where it stands in half-sitting: the hand
/// goes the other way by 0.2267747 of that, at its height in half-sitting (Stasse et al. 2006, section II:
/// "arm motion heuristic"; gain and geometry of the JRL pattern generator). Half-sitting for 0.
ArmAngles arm_swing(double foot_ahead_m);

/// Both arms for the feet of `reference`.
Arms arm_swing(const Reference& reference);

}  // namespace walking
