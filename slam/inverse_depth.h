// Landmarks from their first sight, at any depth to infinity: anchor, bearing and inverse depth.
#pragma once

#include <Eigen/Core>

#include "slam/camera.h"
#include "slam/kalman.h"
#include "slam/options.h"

namespace slam {

/// Civera, Davison, Montiel 2008: y = (c₀, θ, φ, ρ), the point c₀ + m(θ, φ)/ρ. Unlike theirs the angles are
/// of world axes with z up, m = (cos φ cos θ, cos φ sin θ, sin φ), so that a level camera stays far from the
/// pole at any heading.
struct InverseDepth {
  static constexpr int kSize = 6;
};

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

/// m(θ, φ), a unit vector, and ∂m/∂(θ, φ).
Eigen::Vector3d bearing(double theta, double phi);
Matrix32d bearing_jacobian(double theta, double phi);

/// A new landmark on the line of sight `ray` whose pixel has standard deviation sigma_px.
Beginning begin_inverse_depth(const RobotVector& x, const Ray& ray, double sigma_px,
                              const Options::Depth& options);

/// c₀ + m/ρ, ρ no smaller than 1/100 m, and its derivative.
Eigen::Vector3d inverse_depth_position(const Vector6d& y);
Matrix36d inverse_depth_position_jacobian(const Vector6d& y);

/// Linearity index L_d = 4 σ_d |cos α| / d₁ of Civera, Davison, Montiel 2007: below about 0.1 a point with a
/// Gaussian says the same. sigma_rho is the standard deviation of ρ.
double linearity_index(const Vector6d& y, double sigma_rho, const Eigen::Vector3d& r);

}  // namespace slam
