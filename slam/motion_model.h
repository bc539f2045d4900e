// The initial state, and MonoSLAM's constant-velocity model, driven by unknown or measured accelerations.
#pragma once

#include "slam/sensors.h"

namespace slam {

/// The mean state of a robot at rest with its camera at X_WC; all other parameters are 0.
RobotVector initial_mean(const Eigen::Isometry3d& X_WC);

/// Returns the options with the noises of the commanded velocity instead of the planned velocity's.
Options with_command(Options options);
/// Returns the options with the noises of leg odometry, if it is enabled, instead of the planned
/// velocity's.
Options with_leg_odometry(Options options);

/// The options on a floor that is not level: the height from leg odometry drifts from step to step.
Options on_any_floor(Options options);
/// The options without a plan: the robot may start in motion and only near the nominal pose.
Options without_plan(Options options);

/// Mean and covariance of a robot at rest with its camera near X_WC. The covariance is diagonal except for
/// the orientation: the quaternion varies only by small rotations.
RobotState initial_state(const Eigen::Isometry3d& X_WC, const Options& options);

/// The predicted mean f(x), F = ∂f/∂x and the process noise covariance Q.
struct Prediction {
  RobotVector x;
  RobotMatrix F, Q;
};

/// Standard deviation of the velocity of unplanned swaying, m/s along the axes of C.
Eigen::Vector3d sway_sigma(const Options::PlanVelocity& options);

/// r⁺ = r + (v+V)Δt, q⁺ = q × q((ω+Ω)Δt), v⁺ = v+V, ω⁺ = ω+Ω with zero-mean impulses V = aΔt, Ω = αΔt
/// (Davison et al. 2007, eq. (1)-(5)), so that v⁺ and ω⁺ are exactly the mean velocity and rate over the
/// interval. With the accelerometer's velocity increment, V = R(q)(increment − bias·duration) + g·duration
/// plus much smaller noise. With the gyro's rate, ω⁺ = rate − bias plus its noise. Biases are random walks,
/// the errors of stride, sway and height are Gauss-Markov processes, and swaying is a damped oscillation
/// driven by noise. dt_s > 0.
Prediction predict_motion(const RobotVector& x, double dt_s,
                          const std::optional<VelocityIncrement>& increment, const Options& options,
                          const std::optional<MeanRate>& rate = std::nullopt);

}  // namespace slam
