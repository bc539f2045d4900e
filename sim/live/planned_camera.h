// The planned motion of the camera between two ticks of the pattern generator, as the filter gets it at a
// frame.
#pragma once

#include <Eigen/Geometry>

#include "slam/observation.h"
#include "walking/leg_odometry.h"
#include "walking/plan.h"

namespace sim::live {

/// Waist pose X_PB at time t (s), from.t_s <= t <= to.t_s: position and yaw linear between the two references
/// (one control period apart; the plan's acceleration of at most a few m/s² makes that wrong by less than 20
/// µm).
Eigen::Isometry3d planned_waist(const walking::Reference& from, const walking::Reference& to, double t_s);

/// The planned motion of a camera fixed to the waist at X_BC. Velocities: those of the tick before t.
slam::PlannedMotion planned_motion(const walking::Reference& from, const walking::Reference& to, double t_s,
                                   const Eigen::Isometry3d& X_BC);

/// Pose by leg odometry of a camera fixed to the waist at X_BC, by the encoders at this moment.
slam::LegMotion leg_motion(const walking::LegOdometry& legs, const walking::JointVector& q,
                           const Eigen::Isometry3d& X_BC);

}  // namespace sim::live
