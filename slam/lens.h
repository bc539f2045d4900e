// How a lens bends what a pinhole would see: the models the filter's camera knows, each way with its
// Jacobian.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "slam/options.h"

namespace slam {

/// An image point, px from the principal point, and its derivative by the point it was made from.
struct Bent {
  Eigen::Vector2d point;
  Eigen::Matrix2d J;
};

/// Where the lens puts what the pinhole of these focal lengths has at u_c = (fu x/z, fv y/z). Everywhere
/// defined; one to one within widest_angle() alone.
Bent distort(const Lens& lens, const Eigen::Vector2d& focal, const Eigen::Vector2d& u_c);

/// The inverse of distort; nothing where no line of sight is found to give the point d. One that is found
/// beyond widest_angle() means nothing.
std::optional<Bent> undistort(const Lens& lens, const Eigen::Vector2d& focal, const Eigen::Vector2d& d);

/// Up to this angle from the axis (rad, at most 1.5) a point further out is also seen further out: beyond it
/// the polynomials of the models fold back and mean nothing.
double widest_angle(const Lens& lens);

}  // namespace slam
