// A planned walk in the simulator, from its beginning to its end.
#pragma once

#include "sim/physics/walking_robot.h"
#include "tests/sim/physics/half_sitting_world.h"

namespace sim::physics {

/// Waist at the end, true and planned, in the plan's world P.
struct Walked {
  Status status;
  Eigen::Isometry3d X_PB, planned;
};

/// Walks with P at X_WP, until the plan or the robot is at its end.
inline Walked walk(const walking::WalkOptions& options, const walking::StabilizerOptions& stabilizer,
                   const WorldOptions& world = {}, const PlantVariation& draw = {},
                   const Eigen::Isometry3d& X_WP = Eigen::Isometry3d::Identity()) {
  WalkingRobot robot(walking::PatternGenerator(options), stabilizer, world, draw,
                     {"hrp2", world.room, models()}, X_WP);
  while (robot.walks()) robot.tick();
  return {robot.world().status(), X_WP.inverse() * robot.world().X_WB(), robot.reference().X_PB};
}

/// 50 m ahead, 30 m to the right, turned by 115°.
inline Eigen::Isometry3d far_away() {
  Eigen::Isometry3d X_WP = Eigen::Isometry3d::Identity();
  X_WP.translate(Eigen::Vector3d(50, -30, 0)).rotate(Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()));
  return X_WP;
}

}  // namespace sim::physics
