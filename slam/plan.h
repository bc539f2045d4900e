// The walking plan and leg odometry as measurements of the camera's velocity and height.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "slam/measurement.h"
#include "slam/observation.h"
#include "slam/options.h"
#include "slam/state.h"

namespace slam {

/// The motion of the camera over one frame interval, as planned or from leg odometry.
struct PlannedVelocity {
  Eigen::Vector3d velocity;  ///< mean, m/s, along the axes of C at the end or along the plan's world axes
  Eigen::Vector3d rate;      ///< mean angular velocity, rad/s in C
  Eigen::Vector3d p_CF;      ///< mean position of the support foot, m in C
  /// Planned velocity without the swaying of single steps, m/s in C. The stride error is relative to it.
  Eigen::Vector3d steady_C = Eigen::Vector3d::Zero();
  double sigma_m_s = 0;  ///< standard deviation of the velocity's error per axis
};

/// The motion over one frame interval, planned and measured by leg odometry.
struct PlannedInterval {
  PlannedVelocity plan;
  std::optional<PlannedVelocity> legs = {};  ///< replaces the plan, if the filter is to use leg odometry
  SystematicEvidence plan_scale = {};  ///< from the comparison with leg odometry, at the end of two steps
};

/// The mean velocity between two planned poses dt_s apart. steady_C is the velocity of this interval;
/// sigma_m_s is left 0.
PlannedVelocity planned_velocity(const PlannedMotion& before, const PlannedMotion& now, double dt_s,
                                 VelocityAxes axes);

/// The phase of the gait.
struct Gait {
  bool standing = false;
  double since_landing_s = 1e9;                        ///< time since a foot was set down
  Eigen::Vector3d steady_C = Eigen::Vector3d::Zero();  ///< low-pass filtered planned velocity, m/s in C
};

/// The gait after a frame interval of dt_s; `previous` is the gait before it. The planned velocity is
/// averaged over the time of two steps.
Gait planned_gait(const PlannedMotion& before, const PlannedMotion& now, const PlannedVelocity& planned,
                  const Gait& previous, double dt_s, double two_steps_s);

/// Standard deviation of the velocity from leg odometry, m/s per axis: larger just after a landing, while the
/// foot settles on its pads.
double leg_velocity_sigma(const Gait& gait, const Options::LegOdometry& options);

/// Compares the planned motion of the camera over two steps with its motion by leg odometry. Within a step,
/// and as it starts to walk, the robot sways more than planned.
class TwoSteps {
 public:
  /// The evidence for the scale of the planned distances since the landing before last, at every second
  /// landing; else nothing. It starts anew while the plan is `standing` and without leg odometry.
  SystematicEvidence add(const PlannedMotion& before, const PlannedMotion& now, bool standing);

 private:
  std::optional<PlannedMotion> start_;  // at a landing
  int landings_ = 0;                    // since then
};

/// Follows the plan from frame to frame.
class PlanHistory {
 public:
  /// The motion since the previous frame, dt_s ago, with steady_C and sigma_m_s. Nothing if this frame or the
  /// previous one has no plan.
  std::optional<PlannedInterval> advance(const std::optional<PlannedMotion>& plan, double dt_s,
                                         const Options& options);

  /// True until the first planned motion that is not that of a standing robot.
  bool at_rest() const { return previous_ && !moved_; }

 private:
  std::optional<PlannedMotion> previous_;
  Gait gait_;
  TwoSteps two_steps_;
  bool moved_ = false;
};

/// The measurement h = R(q)ᵀ v + e in the robot's axes, or h = v + R(q) e in the plan's (Stasse et al. 2006,
/// section IV-B). The error e is the sum of kSwayVelocity and the stride error times the steady velocity.
/// Beyond the paper, rotation unknown to the plan, as the robot tilts on its compliant ankles, is about the
/// support foot (robot's axes only): the camera also moves by the horizontal part of p_CF × (ω − ω_plan). The
/// vertical part is left out because the next foot lands on the same floor, so that it must not accumulate
/// from step to step. scale: the systematic error of its source, kPlanScale or kLegScale.
Measurement measure_velocity(const RobotVector& x, const PlannedVelocity& planned,
                             const Options::PlanVelocity& options, int scale = kPlanScale);

/// The options with the noises of leg odometry in place of the plan's.
Options with_leg_noises(const Options& options);

/// The measurement h = r_z of the camera's planned height, m (Stasse et al. 2006, section IV-B).
Measurement measure_height(const RobotVector& x, double height_m, const Options::Height& options);

}  // namespace slam
