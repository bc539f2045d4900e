// The first surface of the room on a ray.
#pragma once

#include <optional>
#include <vector>

#include "sim/score/types.h"

namespace sim::score {

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
