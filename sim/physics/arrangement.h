// The room at another time: another start of the robot, another light, and moved furniture.
#pragma once

#include "sim/physics/model.h"
#include "sim/physics/options.h"

namespace sim::physics {

/// Moves furniture and then the whole room in a model of robot and room, so that the robot's start, which is
/// W, is at world.start in the room; and changes the light.
void arrange(mjModel_& model, const WorldOptions& world);

}  // namespace sim::physics
