// The check of a planned walk against its room, before anything is simulated.
#pragma once

#include <filesystem>

#include "sim/scenario/reader.h"

namespace sim::live {

/// Throws ConfigError at the walk command whose planned posture comes too near to a wall or to furniture,
/// unless the scenario allows a run to end as "collided"; std::invalid_argument when the walk cannot be
/// planned; std::runtime_error when a model does not load.
void require_clear_walk(const scenario::ReadScenario& read, const std::filesystem::path& models);

}  // namespace sim::live
