// The internal measurements of one frame interval (Stasse et al. 2006, section IV): the gyro and the walking
// plan, and, beyond the paper, the accelerometer and leg odometry. Each is gated.
#pragma once

#include "slam/kalman.h"
#include "slam/motion_model.h"

namespace slam {

/// Predicts and updates the state with the internal sensors. Fills in their innovations, their use and
/// rejections in a FrameReport.
class InternalMeasurements {
 public:
  InternalMeasurements(const Options& options, const Calibration& calibration);
  /// From now on, the floor is not taken to be level.
  void leave_level() { level_ = false; }
  /// Returns the turn about the vertical by the gyro minus the one by the legs since the previous
  /// observation, dt_s ago, or 0 if one of them is missing.
  double turn_difference(const RobotVector& x, const std::optional<PlannedInterval>& planned,
                         double dt_s) const;
  /// Adds the plan, leg odometry and command of an observation. Returns the motion since the previous
  /// observation, dt_s ago.
  std::optional<PlannedInterval> advance_plan(const Observation& observation, double dt_s) {
    return plan_.advance(observation, dt_s, options_);
  }
  /// Predicts the robot's state at the observation. The accelerometer drives the prediction unless its
  /// readings are incomplete, or its increment is implausible for the motion model or contradicts the plan.
  /// previous: the time of `state`, that is, of the previous observation.
  Prediction predict(const Observation& observation, Stamp previous,
                     const std::optional<PlannedInterval>& planned, const State& state, FrameReport& report);
  /// Updates the predicted state with gyro, velocity and height together. Each is used only if the options
  /// enable it and it passes its gate. A plan that leg odometry replaces is only compared with leg odometry.
  /// Returns false if S is not positive definite.
  bool update(const Observation& observation, Stamp previous, const std::optional<PlannedInterval>& planned,
              Kalman& kalman, FrameReport& report);

 private:
  std::optional<MeanRate> driving_rate(const RobotVector& x) const;

  // As given, and with the noises of leg odometry, of leg odometry on any floor, and of the command.
  Options options_, leg_options_, floor_options_, command_options_;
  Eigen::Isometry3d X_CG_;                             // as calibrated
  std::optional<Eigen::Isometry3d> X_CG_by_encoders_;  // the newest
  PlanHistory plan_;
  std::optional<MeanRate> gyro_rate_;                     // drives the newest prediction
  std::optional<InertialSample> last_rate_, last_force_;  // the last readings that drove it
  double leg_doubt_ = 1;                                  // factor on the variance of leg odometry
  bool level_;
  bool stumbled_ = false;                                   // the legs' height was beyond its gate
  std::array<std::optional<Eigen::Vector3d>, 7> whitened_;  // of the last frame, by sensor
  InertialInterval earlier_, later_;                        // of the last two frame intervals

  // Work space, kept so that a step in the steady state takes no heap memory.
  std::vector<Measurement> accepted_;
  StackedMeasurement stacked_;
};

}  // namespace slam
