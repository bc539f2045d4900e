// Runs the filter on a recording made elsewhere and scores it as far as its truth allows.
#pragma once

#include <filesystem>

#include "sim/result/result.h"

namespace sim::replay {

/// The scenario with which a recording made elsewhere is replayed: no sensor errors in addition to its own,
/// the filter's defaults, and the noise that the folder states. Without a walking plan the initial standard
/// deviation of the gyro's bias is 0.1 rad/s, and the accelerometer is not used. `changes` come last.
scenario::ReadScenario foreign_scenario(const std::filesystem::path& folder,
                                        const scenario::Changes& changes);

/// Runs the filter of `scenario` on the EuRoC/ASL folder and writes a complete result folder. Truth is moved
/// so that its first pose is the filter's start. Throws FileError.
result::Outcome replay_foreign(const scenario::ReadScenario& scenario, const std::filesystem::path& folder,
                               const result::ResultPlace& place, const result::Progress& progress);

}  // namespace sim::replay
