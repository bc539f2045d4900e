// Landmarks by inverse depth: anchor, bearing and inverse depth describe a point at any depth up to infinity.
#pragma once

#include <Eigen/Core>

#include "slam/camera.h"
#include "slam/kalman.h"
#include "slam/options.h"

namespace slam {

/// Civera, Davison, Montiel 2008: the parameters y = (c₀, θ, φ, ρ) describe the point c₀ + m(θ, φ)/ρ. Unlike
/// theirs, the angles refer to world axes with z up, m = (cos φ cos θ, cos φ sin θ, sin φ), so that the pole
/// is far from the image of a level camera at any heading.
struct InverseDepth {
  static constexpr int kSize = 6;
};

/// m(θ, φ), a unit vector, and ∂m/∂(θ, φ).
Eigen::Vector3d bearing(double theta, double phi);
Matrix32d bearing_jacobian(double theta, double phi);

/// The parameters of a new landmark on the ray of a pixel with standard deviation sigma_px, which the lens has moved by
/// `displacement`, px.
LandmarkInitialisation initialise_inverse_depth(const RobotVector& x, const Ray& ray, double sigma_px,
                                                const Eigen::Vector2d& displacement,
                                                const Options::Depth& options);

/// c₀ + m/ρ, where ρ is limited to at least 1/(100 m), and its derivative.
Eigen::Vector3d inverse_depth_position(const Vector6d& y);
Matrix36d inverse_depth_position_jacobian(const Vector6d& y);

/// The linearity index L_d = 4 σ_d |cos α| / d₁ of Civera, Davison, Montiel 2007. Below about 0.1, a point
/// with Gaussian uncertainty describes the landmark as well. sigma_rho: standard deviation of ρ; r: position
/// of the camera.
double linearity_index(const Vector6d& y, double sigma_rho, const Eigen::Vector3d& r);

}  // namespace slam
