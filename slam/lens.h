// Lens distortion: the models of the filter's camera in both directions, with Jacobians.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "slam/options.h"

namespace slam {

/// An image point in px from the principal point, and its derivative with respect to the point that it was
/// computed from.
struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d J;
};

/// The distorted image point of what a pinhole camera with these focal lengths sees at u_c = (fu x/z, fv
/// y/z). Defined everywhere, but one-to-one within widest_angle() only.
Distorted distort(const Lens& lens, const Eigen::Vector2d& focal, const Eigen::Vector2d& u_c);

/// The inverse of distort. Nothing where no ray is found for the point d; a result beyond widest_angle() is
/// meaningless.
std::optional<Distorted> undistort(const Lens& lens, const Eigen::Vector2d& focal, const Eigen::Vector2d& d);

/// The angle from the axis, at most 1.5 rad, up to which the image radius increases with the angle. Beyond it
/// the polynomials of the models fold back and are meaningless.
double widest_angle(const Lens& lens);

}  // namespace slam
