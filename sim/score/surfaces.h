// The surfaces of the room as simple shapes, and the first one on a ray.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace sim::score {

/// Sizes as in MJCF, all half-lengths in m along the axes S of the shape:
/// plane: x and y, 0 for without end; the surface is z = 0, visible only from z > 0 · box: x, y, z · sphere:
/// radius · cylinder: radius, half-height along z · ellipsoid: three radii · capsule: radius, half-length of
/// its straight part.
struct Surface {
  enum class Kind { plane, box, sphere, cylinder, ellipsoid, capsule };
  Kind kind = Kind::box;
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
};

struct Hit {
  std::size_t surface = 0;  ///< its index
  double distance = 0;      ///< m
};

/// Returns the first surface on the ray along the unit vector `direction` from `origin` (both in W), at a
/// distance > 0. From inside a solid the ray meets its surface on the way out.
std::optional<Hit> first_surface(const std::vector<Surface>& surfaces, const Eigen::Vector3d& origin,
                                 const Eigen::Vector3d& direction);

/// Returns the distance of first_surface().
std::optional<double> first_hit(const std::vector<Surface>& surfaces, const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction);

}  // namespace sim::score
