// A world in which the robot stands in half-sitting on a bare floor.
#pragma once

#include <filesystem>

#include "sim/physics/world.h"
#include "walking/hrp2.h"

namespace sim::physics {

using walking::hrp2::half_sitting;

inline std::filesystem::path models() { return std::filesystem::path(GAITSLAM_SOURCE_DIR) / "models"; }

inline World standing(const PlantVariation& draw = {},
                      const Eigen::Isometry3d& X_WB = Eigen::Isometry3d::Identity()) {
  WorldOptions options;
  options.room = "floor";
  return World(options, draw, half_sitting(), X_WB, {"hrp2", options.room, models()});
}

inline void run(World& world, int milliseconds) {
  for (int k = 0; k < milliseconds; ++k) {
    world.step();
  }
}

}  // namespace sim::physics
