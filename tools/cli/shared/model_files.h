// The models that a scenario names, before anything is loaded.
#pragma once

#include <filesystem>

#include "sim/scenario/scenario.h"

namespace cli {

/// Returns the folder of the program's models: that of its source, or share/gaitslam/models of its
/// installation.
std::filesystem::path standard_models();

/// Throws ConfigError "file:line: world.room: is 'kitchen', expected one of ..." if the folder of the
/// models lacks the robot or the room.
void require_models(const sim::scenario::ReadScenario& read, const std::filesystem::path& models);

}  // namespace cli
