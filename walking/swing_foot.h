// The path of the swing foot: vertical take-off and landing, at rest at both ends.
#pragma once

#include <Eigen/Geometry>

#include "walking/footsteps.h"

namespace walking {

/// Where the swinging sole is `elapsed` of single support (0 ... 1) after lift-off, in P. Horizontally it
/// moves from `from` to `to` during the middle 90 % (vertical take-off and landing), along `polynomial`;
/// height is 16 h s² (1-s)²; the heading follows a cubic (Stasse et al. 2006, section II, and the JRL pattern
/// generator).
Eigen::Isometry3d swing_foot(const FootPose& from, const FootPose& to, double elapsed, double step_height_m,
                             SwingPolynomial polynomial);

/// The sole of a foot at `height_m` above its place on the ground, in P.
Eigen::Isometry3d sole(const FootPose& foot, double height_m = 0);

}  // namespace walking
