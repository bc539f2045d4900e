// The room at another time: another start of the robot, other light, and moved furniture.
#pragma once

#include "sim/physics/model.h"
#include "sim/physics/options.h"
#include "walking/plan.h"

namespace sim::physics {

/// Applies world.moved, world.light.turn_deg and world.start to a model of robot and room: the room is moved
/// so that the robot's start, which is W, is at world.start in the room. A piece of furniture is a body that
/// stands on the floor and touches nothing else. Each gets a draw from its own stream; a draw is repeated if
/// on its way the piece would touch something, or if it would stand closer than 0.7 m to the path of the
/// commands and closer than before. After 20 draws it stays. Returns the number of pieces that were moved.
int arrange(mjModel_& model, const WorldOptions& world, const walking::WalkOptions& walk);

}  // namespace sim::physics
