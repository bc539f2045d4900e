// The nominal robot: the constants of HRP-2 that plan and stabilizer are made for. models/README.md names the
// source of each; a test compares them with the simulator's model.
#pragma once

#include <Eigen/Core>
#include <numbers>

namespace walking {

inline constexpr int kJoints = 30;  ///< RLEG 0-5, LLEG 0-5, CHEST 0-1, HEAD 0-1, RARM 0-6, LARM 0-6
using JointVector = Eigen::Matrix<double, kJoints, 1>;

}  // namespace walking

namespace walking::hrp2 {

inline constexpr double kMass = 56.867992;     ///< kg, sum of the published masses of the links
inline constexpr double kHipY = 0.060;         ///< m, hip center from the waist's origin, left positive
inline constexpr double kKneeY = 0.035;        ///< m, knee axis outwards of the hip: the "offset leg"
inline constexpr double kThigh = 0.300;        ///< m
inline constexpr double kShank = 0.300;        ///< m
inline constexpr double kAnkleHeight = 0.105;  ///< m, ankle above the sole
/// Stiffness of the rubber bush between ankle and sole, along and about the axes of the sole.
inline constexpr double kBushUp_n_m = 239018, kBushYaw_nm_rad = 936, kBushPitch_nm_rad = 502,
                        kBushRoll_nm_rad = 707;
inline constexpr double kFootSpacing = 2 * (kHipY + kKneeY);  ///< m between the ankles, feet together
inline constexpr double kUpperArm = 0.25;                     ///< m, and as much from elbow to wrist
inline constexpr double kWaistHeight = 0.6487018511825304;    ///< m, waist above the ground in half-sitting
inline constexpr double kAnkleX = 0.00949035111398315;  ///< m, ankles ahead of the waist in half-sitting
inline constexpr double kComHeight = 0.808291;  ///< m, center of mass above the ground in half-sitting

/// Center of mass in the waist's axes in half-sitting, m. The real one is 1.55 mm to the left: the plan is
/// symmetric, so that left and right walks mirror each other, and leaves that offset to the stabilizer. (Not
/// inline: clang 14 treats an inline vector as zero in constants computed from it at compile time.)
const Eigen::Vector3d kComInWaist{0.013695, 0.0, 0.159589};

/// The corners of a sole about the sole point (below the ankle), x ahead and y left, m.
const Eigen::Vector2d kSoleMin{-0.100, -0.069}, kSoleMax{0.130, 0.069};

inline constexpr int kRightLeg = 0, kLeftLeg = 6, kChestYaw = 12, kChestPitch = 13, kRightArm = 16,
                     kLeftArm = 23;  ///< in JointVector
inline constexpr int kElbow = 3;     ///< joints after the shoulder pitch of its arm
inline constexpr double kShoulderPitch_deg = 15, kElbow_deg = -30;  ///< in half-sitting

/// Half-sitting: the posture the robot stands in and the upper body keeps, rad, order of JointVector.
inline JointVector half_sitting() {
  JointVector q;
  q << 0, 0, -26, 50, -24, 0,                            // right leg
      0, 0, -26, 50, -24, 0,                             // left leg
      0, 0, 0, 0,                                        // chest, head
      kShoulderPitch_deg, -10, 0, kElbow_deg, 0, 0, 10,  // right arm and hand
      kShoulderPitch_deg, 10, 0, kElbow_deg, 0, 0, 10;   // left arm and hand
  return q * (std::numbers::pi / 180);
}

}  // namespace walking::hrp2
