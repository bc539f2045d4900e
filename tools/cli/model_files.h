// The models that a scenario names, before anything is loaded.
#pragma once

#include <filesystem>

#include "sim/scenario/scenario.h"

namespace cli {

/// The folder of the models that this program came with: of its source, or of its installation,
/// share/gaitslam/models beside the folder of the program.
std::filesystem::path standard_models();

/// Throws ConfigError "file:line: world.room: is 'kitchen', expected one of ..." where the folder of the
/// models has no such robot or no such room.
void require_models(const sim::scenario::ReadScenario& read, const std::filesystem::path& models);

}  // namespace cli
