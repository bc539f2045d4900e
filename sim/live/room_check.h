// The plan of a run, checked against its room before anything is simulated.
#pragma once

#include <filesystem>

#include "sim/physics/model.h"
#include "sim/scenario/scenario.h"
#include "walking/pattern_generator.h"

namespace sim::live {

/// Plans the walk. Throws std::invalid_argument if it cannot be planned, and ConfigError at a walk command
/// with a planned posture too near to a wall or to furniture, unless the scenario allows a run to end as
/// "collided".
walking::PatternGenerator clear_plan(const scenario::ReadScenario& read, const physics::Models& models);

/// Only the checks of clear_plan. Throws std::runtime_error if a model does not load.
void require_clear_walk(const scenario::ReadScenario& read, const std::filesystem::path& models);

}  // namespace sim::live
