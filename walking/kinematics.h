// All joints for a posture, and the motion of the whole body.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "walking/plan.h"

namespace walking {

/// All joints for a posture; those that neither legs nor swinging arms have are as in the start posture.
struct BodySolution {
  JointVector q;
  bool left_reached = true, right_reached = true;
};
/// start: of the legs, the angles a moment before.
BodySolution inverse_kinematics(const Robot& robot, const Posture& posture, const JointVector& start);

/// Why the legs cannot take this posture ("the left foot is out of the leg's reach"); nothing if they can.
std::optional<std::string> leg_obstacle(const Robot& robot, const BodySolution& body);

/// The pose of every link.
struct BodyPose {
  Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity();
  JointVector q = {};
};

/// A pose and its rates. v: of the waist's origin, m/s; w: of the waist, rad/s; both in P.
struct BodyMotion {
  BodyPose pose;
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = Eigen::Vector3d::Zero();
  JointVector dq = {};
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
BodyPose pose_of(const Robot& robot, const Reference& reference, const JointVector& start);

/// The motion half-way between two poses `period` apart that leads from one to the other at constant rates.
BodyMotion motion_between(const BodyPose& before, const BodyPose& after, double period = kPeriod);

/// The point of the ground (z = 0) about which gravity and inertia of the whole body have no horizontal
/// moment, at the instant in the middle of two momenta `period` apart: p_x = (m g c_x - dL_y/dt) / (m g +
/// dP_z/dt), p_y = (m g c_y + dL_x/dt) / (m g + dP_z/dt), L about P's origin.
Eigen::Vector2d multibody_zmp(const BodyMomentum& before, const BodyMomentum& after, double period = kPeriod);

}  // namespace walking
