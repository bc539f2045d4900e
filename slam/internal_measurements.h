// The internal measurements of one frame interval (Stasse et al. 2006, section IV): gyro and walking plan,
// and beyond the paper the accelerometer, each gated.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "slam/accelerometer.h"
#include "slam/frame_report.h"
#include "slam/kalman.h"
#include "slam/motion_model.h"
#include "slam/observation.h"
#include "slam/options.h"
#include "slam/plan.h"

namespace slam {

/// A prediction, and whether an accelerometer reading was rejected by its gate.
struct GatedPrediction {
  Prediction prediction;
  bool accelerometer_rejected = false;
};

struct InternalResult {
  /// Absent where there is no measurement. plan_velocity: of leg odometry where that takes the plan's place.
  std::optional<Nis> gyro, plan_velocity, height;
  std::string rejected;  ///< what was not used, and why
  bool updated = true;   ///< false where S is not positive definite
};

class InternalMeasurements {
 public:
  InternalMeasurements(const Options& options, const Eigen::Isometry3d& X_CG)
      : options_(options), by_legs_(options), X_CG_(X_CG) {
    by_legs_.plan_velocity = noises_by_legs(options);
  }

  /// Takes in the plan of an observation; returns the planned motion since the previous one, dt_s ago.
  std::optional<PlannedVelocity> advance_plan(const Observation& observation, double dt_s) {
    return plan_.advance(observation.plan, dt_s, options_);
  }

  /// Predicts the robot's state at the observation. The accelerometer drives the prediction unless its
  /// readings are incomplete, or its increment is implausible for the motion model or contradicts the plan.
  /// previous: the time of the observation before, at which `state` is.
  GatedPrediction predict(const Observation& observation, Stamp previous,
                          const std::optional<PlannedVelocity>& planned, const State& state);

  /// Updates the predicted state with gyro, planned velocity, height, orientation and position at once, each
  /// only if the options enable it and it passes its gate. A plan that is not used, because leg
  /// odometry takes its place, is compared with that.
  InternalResult update(const Observation& observation, Stamp previous,
                        const std::optional<PlannedVelocity>& planned, Kalman& kalman);

 private:
  std::optional<VelocityIncrement> integrate_accelerometer(const Observation& observation, Stamp previous,
                                                           const State& state);
  /// The options with the noises that hold in this frame.
  const Options& options(const std::optional<PlannedVelocity>& planned) const {
    return planned && planned->legs ? by_legs_ : options_;
  }
  Measurement measured_velocity(const RobotVector& x, const PlannedVelocity& planned) const;
  bool agrees_with_plan(const Prediction& prediction, const State& state,
                        const std::optional<PlannedVelocity>& planned) const;

  Options options_, by_legs_;
  Eigen::Isometry3d X_CG_;
  PlanHistory plan_;
  InertialInterval earlier_, later_;  // of the last two frame intervals
  // Work space, kept so that a step in the steady state takes no heap memory.
  std::vector<Measurement> accepted_;
  StackedMeasurement stacked_;
};

}  // namespace slam
