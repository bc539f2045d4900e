// A room on another day: furniture that was moved, and lamps that shine from elsewhere.
#pragma once

#include "sim/physics/model.h"
#include "sim/physics/options.h"
#include "walking/plan.h"

namespace sim::physics {

/// Applies world.moved and world.light.turn_deg to a model with a room. A piece of furniture is a body that
/// stands on the floor and touches nothing else. Each gets a draw from its own stream; a draw is repeated if
/// on its way the piece would touch something, or if it would stand closer than 0.7 m to the path of the
/// commands and closer than before. After 20 draws it stays. Returns the number of pieces that were moved.
int change_room(mjModel_& in_room, const WorldOptions& world, const walking::WalkOptions& walk);

}  // namespace sim::physics
