// Gyro, accelerometer, walking plan and leg odometry: their readings over one frame interval, and their
// measurements. The accelerometer's readings are an input of the motion model.
#pragma once

#include "slam/measurement.h"
#include "slam/options.h"

namespace slam {

/// Mean angular rate of the camera over one frame interval, rad/s in C, and its standard deviation per axis.
struct MeanRate {
  Eigen::Vector3d w_C;
  double sigma_rad_s;
};

/// Gyro and accelerometer readings of one frame interval (from, to], and the pose of the IMU in the camera's
/// frame at both ends.
struct InertialInterval {
  Stamp from{0}, to{0};
  std::vector<InertialSample> gyro, accelerometer;
  Eigen::Isometry3d X_CG_from = Eigen::Isometry3d::Identity(), X_CG_to = X_CG_from;
};

/// Log(R_CG,from Π Exp(w_i dt_i) R_GC,to)/Δt over the gyro readings. The standard deviation is a single
/// reading's, reduced by averaging. If readings cover only a part of the interval, the rate's change in
/// the rest, as assumed by the motion model, increases it. Returns nothing if less than half of the interval
/// is covered. With GyroReadings::last, the result is the last reading.
std::optional<MeanRate> mean_rate(const InertialInterval& interval, const Options& options);

/// The measurement h = ω + bias of the camera's rate (Stasse et al. 2006, section IV-C; Davison et al. 2007);
/// h = ω if the rate is not from the gyro.
Measurement measure_rate(const RobotVector& x, const MeanRate& rate, bool by_gyro = true);

/// v̄⁺ − v̄ = R_WC increment_C + duration g, where v̄ is the mean velocity over a frame interval, R_WC the
/// orientation at the frame between the two intervals and g gravity.
struct VelocityIncrement {
  Eigen::Vector3d increment_C;  ///< m/s
  double duration_s;
  double sigma_m_s;  ///< per axis
};

/// Integration by parts gives v̄⁺ − v̄ = ∫(t₊ − t) a dt/Δ₊ over the later interval + ∫(t − t₋) a dt/Δ over
/// the earlier one. Here a is the acceleration of the chest, rotated by the gyro into the axes of the camera
/// at the frame between the intervals; the motion of the chest relative to the camera is subtracted.
/// gyro_bias_C: rad/s in C. Returns nothing if readings are missing or the intervals do not adjoin.
std::optional<VelocityIncrement> velocity_increment(const InertialInterval& earlier,
                                                    const InertialInterval& later,
                                                    const Eigen::Vector3d& gyro_bias_C,
                                                    const Options& options);

/// The motion of the camera over one frame interval, as planned or as measured by leg odometry.
struct PlannedVelocity {
  Eigen::Vector3d velocity;  ///< mean, m/s, along the axes of C at the end or along the plan's world axes
  Eigen::Vector3d rate;      ///< mean angular velocity, rad/s in C
  Eigen::Vector3d p_CF;      ///< mean position of the support foot, m in C
  /// The velocity without the swaying of single steps, m/s in C. The stride error is relative to it.
  Eigen::Vector3d steady_C = Eigen::Vector3d::Zero();
  double sigma_m_s = 0;      ///< standard deviation of the velocity's error per axis
  double sigma_pivot_m = 0;  ///< standard deviation of p_CF; multiplied by the rotation in excess of `rate`
  /// If not 0, the velocity is the difference of two positions with the errors kLegError and
  /// kPreviousLegError, divided by this time between them.
  double between_positions_s = 0;
};

/// The motion of the robot over one frame interval as known to the robot: at least one of plan, legs and
/// command.
struct PlannedInterval {
  std::optional<PlannedVelocity> plan;
  bool standing = false;  ///< the plan does not move; without a plan, leg odometry does not
  bool steady = false;    ///< it has moved for the duration of two steps, so the steady velocity is known
  std::optional<PlannedVelocity> legs = {};  ///< replaces the plan if the filter uses leg odometry
  /// The commanded velocity, with the lag of the base, ahead and to the left, m/s; only without the other
  /// two.
  std::optional<Eigen::Vector2d> command = {};
  SystematicEvidence plan_scale = {};  ///< from comparing two steps with leg odometry, at their end
};

/// Follows plan, leg odometry and command from frame to frame.
class PlanHistory {
 public:
  /// The motion since the previous frame, dt_s ago. Returns nothing if neither plan nor leg odometry is
  /// available at both frames and no velocity is commanded.
  std::optional<PlannedInterval> advance(const Observation& observation, double dt_s, const Options& options);
  /// True if there is a plan and it has not moved yet.
  bool at_rest() const { return previous_.plan && moved_s_ == 0; }

 private:
  struct Known {
    std::optional<PlannedMotion> plan;
    std::optional<LegMotion> legs;
  };
  SystematicEvidence compare_two_steps(const Known& now, bool landed, bool standing);

  Known previous_;
  std::optional<Known> start_;                // landing at which the two steps being compared began
  int landings_ = 0;                          // landings since then
  std::optional<Eigen::Vector2d> planned_m_;  // planned motion over the previous two steps
  double moved_s_ = 0;
  Eigen::Vector3d steady_C_ = Eigen::Vector3d::Zero();      // low-pass filtered velocity, m/s in C
  Eigen::Vector2d followed_m_s_ = Eigen::Vector2d::Zero();  // command with the lag of the base
};

/// The measurement h = R(q)ᵀ v + e in the robot's axes, or h = v + R(q) e in the plan's (Stasse et al. 2006,
/// section IV-B). The error e is the sum of kSwayVelocity, the stride error times the steady velocity,
/// kSwayScale times the rest of the velocity, and the change of kLegError divided by the time. Beyond the
/// paper, rotation that the plan does not contain, as when the robot tilts on its compliant ankles, is
/// assumed to be about the support foot (robot's axes only): the camera also moves by the horizontal part of
/// p_CF × (ω − ω_plan). The vertical part is left out because it must not accumulate from step to step: the
/// next foot lands on the same floor. scale: the systematic error of the velocity's source, kPlanScale or
/// kLegScale.
Measurement measure_velocity(const RobotVector& x, const PlannedVelocity& planned,
                             const Options::PlanVelocity& options, int scale = kPlanScale);

/// The measurement h = D(q) v + e of the commanded velocity, where D maps to the heading of the optical axis
/// and to its left. The error e consists of the stride error, relative to the command, and the swaying of the
/// body.
Measurement measure_command(const RobotVector& x, const Eigen::Vector2d& commanded_m_s,
                            const Options::Command& options);

/// The measurement h = r_z + kHeightError of the camera's height, m (Stasse et al. 2006, section IV-B).
Measurement measure_height(const RobotVector& x, double height_m, const Options::Height& options);

}  // namespace slam
