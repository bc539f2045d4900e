// Motions of a step: paths of the swing foot and of the heading of the waist, and the swing of the arms.
#pragma once

#include <Eigen/Geometry>

#include "walking/footsteps.h"
#include "walking/timeline.h"

namespace walking {

/// 3s² - 2s³ for s in [0, 1]: velocity zero at both ends, acceleration not.
constexpr double cubic_blend(double s) { return s * s * (3 - 2 * s); }

/// 10s³ - 15s⁴ + 6s⁵ for s in [0, 1]: velocity and acceleration zero at both ends.
constexpr double quintic_blend(double s) { return s * s * s * (10 + s * (6 * s - 15)); }

/// Returns the swinging sole at `elapsed` (0 ... 1) of single support, in P. Horizontally it
/// moves from `from` to `to` during the middle 90 % (vertical take-off and landing), along `polynomial`;
/// height is 16 h s² (1-s)²; the heading follows a cubic (Stasse et al. 2006, section II, and the JRL pattern
/// generator).
Eigen::Isometry3d swing_foot(const FootPose& from, const FootPose& to, double elapsed, double step_height_m,
                             SwingPolynomial polynomial);

/// The sole of a foot at `height_m` above its place on the ground, in P.
Eigen::Isometry3d sole(const FootPose& foot, double height_m = 0);

struct WaistYaw {
  double yaw = 0;   ///< rad, never wrapped
  double rate = 0;  ///< rad/s
};

/// Cubic from the heading at the start of the phase to that at its end, `elapsed` in 0 ... 1 of the phase
/// (Stasse et al. 2006, section II: the waist turns in yaw only, on a third-order polynomial).
WaistYaw waist_yaw(const Phase& phase, double elapsed);

/// Returns the arm for a foot on its side that is `foot_ahead_m` ahead of half-sitting: the hand goes the
/// other way by 0.2267747 of that, at its height in half-sitting (Stasse et al. 2006, section II: "arm motion
/// heuristic"; gain and geometry of the JRL pattern generator). Half-sitting for 0.
ArmAngles arm_swing(double foot_ahead_m);

/// Both arms for the feet of `reference`.
Arms arm_swing(const Reference& reference);

}  // namespace walking
