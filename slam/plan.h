// What the walking pattern generator says, as measurements: velocity of the camera, and its height.
#pragma once

#include <Eigen/Geometry>

#include "slam/kalman.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace slam {

/// How the plan has the camera move between two frames.
struct PlannedStride {
  Eigen::Vector3d velocity;  ///< mean, m/s
  Eigen::Vector3d rate;      ///< mean angular velocity, rad/s in C
  Eigen::Vector3d p_CF;      ///< mean place of the support foot, m in C
  /// Without the swaying of single steps, along the camera's own axes, m/s: what kStride is a part of.
  Eigen::Vector3d steady_C = Eigen::Vector3d::Zero();
};

/// Planned mean velocity between two planned poses dt_s apart: along the camera's own axes at the later one,
/// or along the plan's world axes. m/s.
PlannedStride planned_stride(const PlannedMotion& before, const PlannedMotion& now, double dt_s,
                             VelocityAxes axes);

/// What the plan is doing, as far as its error depends on it.
struct Gait {
  bool standing = false, both_feet = false;
  double since_landing_s = 1e9;  ///< since it set a foot down
  double turning_rad_s = 0;
  Eigen::Vector3d steady_C = Eigen::Vector3d::Zero();  ///< planned velocity, its swaying averaged out, m/s
};

/// What the plan does over a stride of dt_s that ended now; before: what it did till then.
Gait planned_gait(const PlannedMotion& before, const PlannedMotion& now, const PlannedStride& stride,
                  const Gait& till_then, double dt_s);

/// Standard deviation of the planned velocity's error: feet slip while turning and landing, and hardly while
/// standing. m/s per axis.
double velocity_sigma(const Gait& gait, const Options::PlanVelocity& options);

/// h = R(q)ᵀ v + slip in the robot's axes, h = v + R(q) slip in the plan's (Stasse et al. 2006, section
/// III-C). In the robot's axes, and going beyond the paper: turning that the plan does not know of (the robot
/// tilts on the compliance of its ankles) is about the support foot, so that the camera moves by the level
/// part of p_CF × (ω − ω_plan) besides. Its height is left out: the next foot finds the same floor, so that
/// what the tilting of one step after another would add up to does not. `slip` is all that the plan's
/// velocity has too much: kSlip, kSwayVelocity, and what kStride makes of its steady velocity.
Measurement measure_velocity(const RobotVector& x, const PlannedStride& stride,
                             const Options::PlanVelocity& options);

/// h = 2 vec(q_planned⁻¹ × q), the small turn from the planned orientation to the believed one, 0 as measured
/// (Stasse et al. 2006, section IV-B). rad in C.
Measurement measure_orientation(const RobotVector& x, const Eigen::Matrix3d& R_PC,
                                const Options::PlanOrientation& options);

/// h = r: planned position of the camera, m (Stasse et al. 2006, section IV-B).
Measurement measure_position(const RobotVector& x, const Eigen::Vector3d& p_PC,
                             const Options::PlanPosition& options);

/// h = r_z: planned height of the camera above the ground, m (Stasse et al. 2006, section III-C).
Measurement measure_height(const RobotVector& x, double height_m, const Options::Height& options);

}  // namespace slam
