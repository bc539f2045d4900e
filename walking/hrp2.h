// The nominal robot the plan is made for: geometry of HRP-2's legs, half-sitting posture and where its mass
// is.
#pragma once

#include <Eigen/Core>
#include <numbers>

#include "walking/plan.h"

namespace walking::hrp2 {

inline constexpr double kHipY = 0.060;         ///< m, hip centre from the waist's origin, left positive
inline constexpr double kKneeY = 0.035;        ///< m, knee axis outwards of the hip: the "offset leg"
inline constexpr double kThigh = 0.300;        ///< m
inline constexpr double kShank = 0.300;        ///< m
inline constexpr double kAnkleHeight = 0.105;  ///< m, ankle above the sole
inline constexpr double kFootSpacing =
    0.190;  ///< m between the ankles with the feet together, 2 (kHipY + kKneeY)
inline constexpr double kWaistHeight = 0.6487018511825304;  ///< m, waist above the ground in half-sitting
inline constexpr double kAnkleX = 0.00949035111398315;      ///< m, ankles ahead of the waist in half-sitting

inline constexpr int kRightArm = 16, kLeftArm = 23;  ///< shoulder pitches in JointVector
inline constexpr int kElbow = 3;                     ///< joints after its shoulder pitch

/// Centre of mass in the waist's axes in half-sitting, m. The real one is 1.55 mm to the left: the plan is
/// symmetric, so that left and right walks mirror each other, and leaves that offset to the stabiliser.
inline const Eigen::Vector3d kComInWaist{0.013695, 0.0, 0.159589};

/// Half-sitting: the posture the robot stands in and the upper body keeps, rad, order of JointVector.
inline JointVector half_sitting() {
  JointVector q;
  q << 0, 0, -26, 50, -24, 0,     // right leg
      0, 0, -26, 50, -24, 0,      // left leg
      0, 0, 0, 0,                 // chest, head
      15, -10, 0, -30, 0, 0, 10,  // right arm and hand
      15, 10, 0, -30, 0, 0, 10;   // left arm and hand
  return q * (std::numbers::pi / 180);
}

}  // namespace walking::hrp2
