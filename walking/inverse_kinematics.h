// The joint angles of a posture: HRP-2's offset legs in closed form.
#pragma once

#include <Eigen/Geometry>

#include "walking/plan.h"

namespace walking {

/// A leg's joint angles, rad: hip yaw, hip roll, hip pitch, knee, ankle pitch, ankle roll.
struct LegSolution {
  Eigen::Matrix<double, 6, 1> q;
  /// False if the ankle is too far or too close or the hip is below the sole; the leg then goes as far as it
  /// can.
  bool reached = true;
};

/// `X_BA`: the ankle (axes of the sole) in the waist. Knee bent forwards. Closed form after Kajita's leg,
/// with the knee's lateral offset of HRP-2.
LegSolution leg_inverse_kinematics(Side side, const Eigen::Isometry3d& X_BA);

/// All joints for a posture; chest, head, wrists and hands in half-sitting.
struct BodySolution {
  JointVector q;
  bool left_reached = true, right_reached = true;
};
BodySolution inverse_kinematics(const Posture& posture);

}  // namespace walking
