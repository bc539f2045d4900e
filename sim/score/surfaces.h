// Where a ray first meets a surface of the room.
#pragma once

#include <optional>
#include <vector>

#include "sim/score/types.h"

namespace sim::score {

struct Hit {
  std::size_t surface = 0;  ///< its index
  double distance = 0;      ///< m
};

/// The surface that a ray along the unit vector `direction` from `origin` (both in W) meets first, at a
/// distance > 0; nothing if it meets none. From inside a solid it meets the solid's surface on the way out.
std::optional<Hit> first_surface(const std::vector<Surface>& surfaces, const Eigen::Vector3d& origin,
                                 const Eigen::Vector3d& direction);

/// Its distance alone.
std::optional<double> first_hit(const std::vector<Surface>& surfaces, const Eigen::Vector3d& origin,
                                const Eigen::Vector3d& direction);

}  // namespace sim::score
