// A world in which the robot stands in half-sitting on a bare floor.
#pragma once

#include <numbers>

#include "sim/world/world.h"

namespace sim::world {

inline walking::JointVector half_sitting() {
  constexpr double kDegree = std::numbers::pi / 180;
  walking::JointVector q = walking::JointVector::Zero();
  q.segment<6>(0) << 0, 0, -26, 50, -24, 0;
  q.segment<6>(6) << 0, 0, -26, 50, -24, 0;
  q.segment<7>(16) << 15, -10, 0, -30, 0, 0, 10;
  q.segment<7>(23) << 15, 10, 0, -30, 0, 0, 10;
  return q * kDegree;
}

inline std::filesystem::path models() { return std::filesystem::path(GAITSLAM_SOURCE_DIR) / "models"; }

inline World standing(const Draw& draw = {}, const Eigen::Isometry3d& X_WB = Eigen::Isometry3d::Identity()) {
  WorldOptions options;
  options.room = "floor";
  return World(options, draw, half_sitting(), X_WB, models());
}

inline void run(World& world, int milliseconds) {
  for (int k = 0; k < milliseconds; ++k) {
    world.step();
  }
}

}  // namespace sim::world
