// The arms swing against the legs, so that their yaw momentum makes up for part of that of the legs.
#pragma once

#include "walking/plan.h"
#include "walking/stabilizer.h"

namespace walking {

/// Sagittal angles of an arm, rad.
struct ArmAngles {
  double shoulder_pitch = 0, elbow = 0;
};

/// The arm while the foot on its side is `foot_ahead_m` ahead of where it stands in half-sitting: the hand
/// goes the other way by 0.2267747 of that, at its height in half-sitting (Stasse et al. 2006, section II:
/// "arm motion heuristic"; gain and geometry of the JRL pattern generator). Half-sitting for 0.
ArmAngles arm_swing(double foot_ahead_m);

/// Sets the sagittal angles of both arms in `q` as the feet of `posture` ask for.
void swing_arms(const Posture& posture, JointVector& q);

}  // namespace walking
