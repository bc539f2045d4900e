// What the walking pattern generator says, as measurements: velocity of the camera, and its height.
#pragma once

#include <Eigen/Geometry>

#include "slam/kalman.h"
#include "slam/options.h"

namespace slam {

/// Planned mean velocity between two planned poses dt_s apart: along the camera's own axes at the later one,
/// or along the plan's world axes. m/s.
Eigen::Vector3d planned_velocity(const Eigen::Isometry3d& X_PC_before, const Eigen::Isometry3d& X_PC,
                                 double dt_s, VelocityAxes axes);

/// h = R(q)ᵀ v + slip in the robot's axes, h = v + R(q) slip in the plan's (Stasse et al. 2006, section
/// III-C).
Measurement measure_velocity(const RobotVector& x, const Eigen::Vector3d& velocity,
                             const Options::PlanVelocity& options);

/// h = r_z: planned height of the camera above the ground, m (Stasse et al. 2006, section III-C).
Measurement measure_height(const RobotVector& x, double height_m, const Options::Height& options);

}  // namespace slam
