// Inverse kinematics of the whole robot for a posture, and the motion of the whole body.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "walking/plan.h"

namespace walking {

/// The angles of all joints for a posture. Joints that belong to neither legs nor swinging arms stay as in
/// the start posture.
struct BodySolution {
  JointVector q;
  bool left_reached = true, right_reached = true;
};
/// start: the leg angles a moment earlier.
BodySolution inverse_kinematics(const Robot& robot, const Posture& posture, const JointVector& start);

/// Returns why the legs cannot take this posture (such as "the left foot is out of the leg's reach"), or
/// nothing if they can.
std::optional<std::string> leg_obstacle(const Robot& robot, const BodySolution& body);

/// The pose of every link.
struct BodyPose {
  Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity();
  JointVector q = {};
};

/// A pose and its rates. v: velocity of the waist's origin, m/s; w: angular velocity of the waist, rad/s;
/// both in P.
struct BodyMotion {
  BodyPose pose;
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = Eigen::Vector3d::Zero();
  JointVector dq = {};
};

/// Mass (kg) and, in P, center of mass (m), momentum (kg m/s) and angular momentum about the center of mass
/// (kg m²/s).
struct BodyMomentum {
  double mass = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero(), linear = Eigen::Vector3d::Zero(),
                  angular = Eigen::Vector3d::Zero();
};

/// The plan's nominal model of the robot, never the varied or disturbed robot that walks.
using WholeBody = std::function<BodyMomentum(const BodyMotion&)>;

/// The pose that the plan itself describes, by inverse kinematics.
BodyPose pose_of(const Robot& robot, const Reference& reference, const JointVector& start);

/// Returns the pose after a part (0 to 1) of the way between two poses: linear, with the shortest turn.
Eigen::Isometry3d pose_between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double part);

/// The motion halfway between two poses that are `period` apart and joined at constant rates.
BodyMotion motion_between(const BodyPose& before, const BodyPose& after, double period = kPeriod);

/// The point of the ground (z = 0) about which gravity and inertia of the whole body have no horizontal
/// moment, at the instant midway between two momenta that are `period` apart: p_x = (m g c_x - dL_y/dt) / (m
/// g + dP_z/dt), p_y = (m g c_y + dL_x/dt) / (m g + dP_z/dt), L about P's origin.
Eigen::Vector2d multibody_zmp(const BodyMomentum& before, const BodyMomentum& after, double period = kPeriod);

}  // namespace walking
