// A planned walk, walked: plan, stabiliser, inverse kinematics and physics together.
#pragma once

#include "tests/sim/world/half_sitting_world.h"
#include "walking/inverse_kinematics.h"
#include "walking/pattern_generator.h"

namespace sim::world {

/// Waist at the end, true and planned, in the plan's world P.
struct Walked {
  Status status;
  Eigen::Isometry3d X_PB, planned;
};

/// Walks with P at X_WP, until the plan or the robot is at its end.
inline Walked walk(const walking::WalkOptions& options, const walking::StabilizerOptions& stabilizer_options,
                   const WorldOptions& world_options = {}, const Draw& draw = {},
                   const Eigen::Isometry3d& X_WP = Eigen::Isometry3d::Identity()) {
  walking::PatternGenerator generator(options);
  walking::Stabilizer stabilizer(stabilizer_options);
  walking::Reference reference = generator.next();
  walking::JointVector q = walking::inverse_kinematics(walking::posture_of(reference)).q;
  World world(world_options, draw, q, X_WP * reference.X_PB, models());
  for (std::size_t tick = 0; tick < generator.ticks() && world.status().condition == Condition::ok; ++tick) {
    const walking::JointVector next = walking::inverse_kinematics(stabilizer.step(reference, world.felt())).q;
    world.command(next, (next - q) / walking::kPeriod);
    q = next;
    run(world, 5);
    reference = generator.next();
  }
  return {world.status(), X_WP.inverse() * world.X_WB(), reference.X_PB};
}

/// 50 m ahead, 30 m to the right, turned by 115°.
inline Eigen::Isometry3d far_away() {
  Eigen::Isometry3d X_WP = Eigen::Isometry3d::Identity();
  X_WP.translate(Eigen::Vector3d(50, -30, 0)).rotate(Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()));
  return X_WP;
}

}  // namespace sim::world
