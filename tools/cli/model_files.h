// The models that a scenario names, before anything is loaded.
#pragma once

#include <filesystem>

#include "sim/scenario/scenario.h"

namespace cli {

/// Throws ConfigError "file:line: world.room: is 'kitchen', expected one of ..." where the folder of the
/// models has no such robot or no such room.
void require_models(const sim::scenario::ReadScenario& read, const std::filesystem::path& models);

}  // namespace cli
