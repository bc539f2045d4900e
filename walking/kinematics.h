// Kinematics of HRP-2: soles from leg angles and back, joint limits, and the motion of the whole body.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "walking/plan.h"

namespace walking {

/// X_BS: the sole (point below the ankle) in the waist; q as in LegSolution.
Eigen::Isometry3d sole_in_waist(Side side, const Eigen::Matrix<double, 6, 1>& q);

/// R_B of the chest, by its two joints.
Eigen::Matrix3d chest_in_waist(const JointVector& q);

/// `X_BA`: the ankle (axes of the sole) in the waist. After Kajita's leg, with HRP-2's lateral knee offset.
LegSolution leg_inverse_kinematics(Side side, const Eigen::Isometry3d& X_BA);

/// All joints for a posture; chest, head, wrists and hands in half-sitting.
struct BodySolution {
  JointVector q;
  bool left_reached = true, right_reached = true;
};
BodySolution inverse_kinematics(const Posture& posture);

/// Lowest and highest angle of each joint of a leg, rad, in the order of LegSolution::q.
struct LegLimits {
  Eigen::Matrix<double, 6, 1> lowest, highest;
};

/// Limits of the stack-of-tasks model of HRP-2; the left leg mirrors the right one.
LegLimits leg_limits(Side side);

/// Why the legs cannot take this posture ("the left foot is out of the leg's reach"); nothing if they can.
std::optional<std::string> leg_obstacle(const BodySolution& body);

/// The pose of every link.
struct BodyPose {
  Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity();
  JointVector q = JointVector::Zero();
};

/// A pose and its rates. v: of the waist's origin, m/s; w: of the waist, rad/s; both in P.
struct BodyMotion {
  BodyPose pose;
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = Eigen::Vector3d::Zero();
  JointVector dq = JointVector::Zero();
};

/// Mass (kg), and in P center of mass (m), momentum (kg m/s), angular momentum about that center (kg m²/s).
struct BodyMomentum {
  double mass = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero(), linear = Eigen::Vector3d::Zero(),
                  angular = Eigen::Vector3d::Zero();
};

/// A model of the robot: the plan's nominal one, never the (varied, disturbed) one that walks.
using WholeBody = std::function<BodyMomentum(const BodyMotion&)>;

/// The plan's own pose, by inverse kinematics.
BodyPose pose_of(const Reference& reference);

/// The motion half-way between two poses `period` apart that leads from one to the other at constant rates.
BodyMotion motion_between(const BodyPose& before, const BodyPose& after, double period = kPeriod);

/// The point of the ground (z = 0) about which gravity and inertia of the whole body have no horizontal
/// moment, at the instant in the middle of two momenta `period` apart: p_x = (m g c_x - dL_y/dt) / (m g +
/// dP_z/dt), p_y = (m g c_y + dL_x/dt) / (m g + dP_z/dt), L about P's origin.
Eigen::Vector2d multibody_zmp(const BodyMomentum& before, const BodyMomentum& after, double period = kPeriod);

}  // namespace walking
