// Plan and robot of a run before its first tick.
#pragma once

#include <cstdint>

#include "sim/physics/world.h"
#include "sim/scenario/scenario.h"
#include "walking/pattern_generator.h"

namespace sim::live {

/// Returns the plan of the walk. Throws std::invalid_argument if it cannot be planned, and ConfigError at a
/// walk command with a planned posture too close to a wall or furniture, unless the scenario allows a run to
/// end as "collided".
walking::PatternGenerator clear_plan(const scenario::ReadScenario& read, const physics::Models& models);

/// Returns the variations, each from its own named stream, so a spread of 0 does not change the others.
physics::PlantVariation plant_variation(std::uint64_t seed, const physics::WorldOptions& world);

}  // namespace sim::live
