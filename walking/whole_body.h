// The plan's own model of the whole robot, from motion to momentum. Whoever has a multibody model supplies
// it.
#pragma once

#include <Eigen/Geometry>
#include <functional>

#include "walking/plan.h"

namespace walking {

/// Where every link is.
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

/// Mass (kg), centre of mass (m), momentum (kg m/s) and angular momentum about the centre of mass (kg m²/s),
/// in P.
struct BodyMomentum {
  double mass = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero(), linear = Eigen::Vector3d::Zero(),
                  angular = Eigen::Vector3d::Zero();
};

/// A model of the robot. It must be the plan's nominal one, never the (varied, disturbed) one that is being
/// walked.
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
