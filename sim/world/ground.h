// The floor: its friction and its height at each point.
#pragma once

#include <Eigen/Core>

#include "sim/world/options.h"

namespace sim::world {

/// The sliding friction at a point (m, in W).
double friction_at(const Eigen::Vector2d& p_W, double elsewhere, const std::vector<FloorPatch>& patches);

/// The floor's height at a point, m.
double height_at(const Eigen::Vector2d& p_W, const std::vector<FloorWave>& waves);

}  // namespace sim::world
