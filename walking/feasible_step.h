// Where a foot may land beside the one that stands.
#pragma once

#include "walking/footsteps.h"

namespace walking {

/// How far a landing is outside the places where steps are known to work, m; 0 inside. The area, seen from
/// the standing foot, has its outer corners at 0.4 m aside, (±0.2, 0.3) m and (±0.28, 0.2) m (Herdt et al.
/// 2010, as in jrl-walkgen), less a margin of 0.04 m; on the inside the soles keep 0.01 m from each other.
double distance_outside(const FootPose& standing, const Footstep& landing);

}  // namespace walking
