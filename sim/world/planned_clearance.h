// Whether a plan leads the robot past the walls and the furniture of its room.
#pragma once

#include <filesystem>
#include <optional>

#include "sim/world/options.h"
#include "sim/world/room_clearance.h"
#include "walking/pattern_generator.h"

namespace sim::world {

/// How far a planned robot keeps from the room, m: for the sway about its plan. A long walk drifts farther; a run
/// that thereby touches something ends as "collided".
inline constexpr double kPlannedMargin_m = 0.05;

struct PlannedCollision : Collision {
  double t_s = 0;
  int command = 0;  ///< index into WalkOptions::commands
};

/// The first time at which the planned posture, the plan's world being W, is nearer than kPlannedMargin_m to
/// the room. Throws std::runtime_error when a model does not load.
std::optional<PlannedCollision> first_collision(walking::PatternGenerator plan, const WorldOptions& world,
                                                const std::filesystem::path& models);

}  // namespace sim::world
