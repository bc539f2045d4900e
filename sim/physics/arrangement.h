// The room at another time: another start of the robot, another light, and moved furniture.
#pragma once

#include "sim/physics/model.h"
#include "sim/physics/options.h"

namespace sim::physics {

/// Returns a model of robot and room with moved furniture, with the whole room moved so that the robot's
/// start, which is W, is at world.start in the room, and with the light changed.
Model arranged(Model model, const WorldOptions& world);

}  // namespace sim::physics
