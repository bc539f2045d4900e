// The walking plan as measurements: velocity, height, orientation and position of the camera.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "slam/measurement.h"
#include "slam/observation.h"
#include "slam/options.h"
#include "slam/state.h"

namespace slam {

/// The same interval's motion by leg odometry.
struct LegVelocity {
  Eigen::Vector3d velocity;  ///< mean, m/s along the axes of C at the end
  Eigen::Vector3d rate;      ///< mean angular velocity, rad/s in C
  Eigen::Vector3d p_CS;      ///< mean position of the sole that carries the robot, m in C
  double sigma_m_s = 0;      ///< standard deviation of the velocity's error per axis
  SystematicEvidence plan_scale = {};  ///< what it says of the planned distances, at the end of two steps
};

/// The planned motion of the camera over one frame interval.
struct PlannedVelocity {
  Eigen::Vector3d velocity;  ///< mean, m/s, along the axes of C at the end or along the plan's world axes
  Eigen::Vector3d rate;      ///< mean angular velocity, rad/s in C
  Eigen::Vector3d p_CF;      ///< mean position of the support foot, m in C
  /// Planned velocity, m/s in C, to which the stride error is relative: without the swaying of single steps.
  Eigen::Vector3d steady_C = Eigen::Vector3d::Zero();
  double sigma_m_s = 0;                  ///< standard deviation of the velocity's error per axis
  std::optional<LegVelocity> legs = {};  ///< where the filter is to use it in the plan's place
};

/// The mean velocity between two planned poses dt_s apart. steady_C is the velocity of this interval alone;
/// sigma_m_s is left 0.
PlannedVelocity planned_velocity(const PlannedMotion& before, const PlannedMotion& now, double dt_s,
                                 VelocityAxes axes);

/// The phase of the gait, as far as the error of the plan depends on it.
struct Gait {
  bool standing = false, double_support = false;
  double since_landing_s = 1e9;  ///< time since a foot was set down
  double turning_rad_s = 0;
  Eigen::Vector3d steady_C = Eigen::Vector3d::Zero();  ///< low-pass filtered planned velocity, m/s in C
};

/// The gait after a frame interval of dt_s that ends now; `previous` is the gait before it.
Gait planned_gait(const PlannedMotion& before, const PlannedMotion& now, const PlannedVelocity& planned,
                  const Gait& previous, double dt_s);

/// Standard deviation of the planned velocity's error, m/s per axis: feet slip while the robot turns and
/// lands, and hardly while it stands.
double velocity_sigma(const Gait& gait, const Options::PlanVelocity& options);

/// Compares how far the camera is planned to move in two steps with how far it moved by leg odometry. Within
/// a step, and as it begins to walk, the robot sways more than planned.
class TwoSteps {
 public:
  /// What the motion since the landing before last says of the scale of the planned distances; nothing but at
  /// every second landing. standing: the plan stands; there and without leg odometry it begins anew.
  SystematicEvidence take(const PlannedMotion& before, const PlannedMotion& now, bool standing);

 private:
  std::optional<PlannedMotion> begin_;  // at a landing
  int landings_ = 0;                    // since then
};

/// Follows the plan from frame to frame.
class PlanHistory {
 public:
  /// The planned motion since the previous frame, dt_s ago, with steady_C and sigma_m_s by the gait. Nothing
  /// where this frame or the previous one has no plan.
  std::optional<PlannedVelocity> advance(const std::optional<PlannedMotion>& plan, double dt_s,
                                         const Options& options);

  /// True as long as all planned motions are those of a robot that stands.
  bool at_rest() const { return previous_ && !moved_; }

 private:
  std::optional<PlannedMotion> previous_;
  Gait gait_;
  TwoSteps two_steps_;
  bool moved_ = false;
};

/// The measurement h = R(q)ᵀ v + e in the robot's axes, or h = v + R(q) e in the plan's (Stasse et al. 2006,
/// section IV-B). The error e is the sum of kSlip, kSwayVelocity and the stride error times the steady
/// velocity. Beyond the paper, rotation unknown to the plan, as the robot tilts on its compliant ankles, is
/// taken to be about the support foot (robot's axes only): the camera also moves by the horizontal part of
/// p_CF × (ω − ω_plan). The vertical part is left out because the next foot lands on the same floor, so that
/// it must not accumulate from step to step.
Measurement measure_velocity(const RobotVector& x, const PlannedVelocity& planned,
                             const Options::PlanVelocity& options);

/// The same of the velocity by leg odometry, which there must be; it depends on the scale of leg odometry in
/// the place of that of the plan.
Measurement measure_leg_velocity(const RobotVector& x, const PlannedVelocity& planned,
                                 const Options::PlanVelocity& options);

/// The options of plan_velocity as they hold where leg odometry takes the plan's place.
Options::PlanVelocity noises_by_legs(const Options& options);

/// The measurement of h = 2 vec(q_planned⁻¹ × q), the small rotation from the planned to the estimated
/// orientation, as 0 (Stasse et al. 2006, section IV-B). rad in C.
Measurement measure_orientation(const RobotVector& x, const Eigen::Matrix3d& R_PC,
                                const Options::PlanOrientation& options);

/// The measurement h = r of the camera's planned position, m (Stasse et al. 2006, section IV-B).
Measurement measure_position(const RobotVector& x, const Eigen::Vector3d& p_PC,
                             const Options::PlanPosition& options);

/// The measurement h = r_z of the camera's planned height, m (Stasse et al. 2006, section IV-B).
Measurement measure_height(const RobotVector& x, double height_m, const Options::Height& options);

}  // namespace slam
