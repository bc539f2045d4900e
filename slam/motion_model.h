// How the camera moves between frames: MonoSLAM's constant velocity, driven by unknown accelerations.
#pragma once

#include <optional>

#include "slam/accelerometer.h"
#include "slam/options.h"
#include "slam/state.h"

namespace slam {

/// f(x), ∂f/∂x and the covariance that the unknown impulses add.
struct Prediction {
  RobotVector x;
  RobotMatrix F, Q;
};

/// Standard deviation of the unknown swaying's velocity along the axes of C, m/s.
Eigen::Vector3d sway_sigma(const Options::PlanVelocity& options);

/// r⁺ = r + (v+V)Δt, q⁺ = q × q((ω+Ω)Δt), v⁺ = v+V, ω⁺ = ω+Ω with zero-mean impulses V = aΔt, Ω = αΔt
/// (Davison et al. 2007, eq. (1)-(5)); so v⁺ and ω⁺ are exactly the mean velocity and rate over the interval.
/// With an impulse from the accelerometer V = R(q)(impulse − bias·duration) + g·duration + noise, far
/// smaller, takes the place of aΔt. Biases are random walks, slip a Gauss-Markov process, sway a
/// noise-driven damped oscillation. dt_s > 0.
Prediction predict_motion(const RobotVector& x, double dt_s, const std::optional<Impulse>& impulse,
                          const Options& options);

}  // namespace slam
