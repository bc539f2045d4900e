// Runs the filter on a recording made elsewhere and scores it as far as its truth allows.
#pragma once

#include <filesystem>

#include "sim/bench/result.h"

namespace sim::bench {

/// The scenario that a folder made elsewhere is replayed with: its name, no sensor errors on top of its own,
/// the filter's defaults. Without a walking plan nothing is known of the sensors beyond what the folder says:
/// the gyro's bias begins unknown to 0.1 rad/s, and the accelerometer is left alone. `changes` come last.
ReadScenario foreign_scenario(const std::filesystem::path& folder, const Changes& changes);

/// Runs the filter of `scenario` on the EuRoC/ASL folder and leaves a complete result folder. The first true
/// pose is laid on the filter's start, so that errors count from there. Throws FileError.
Outcome replay_foreign(const ReadScenario& scenario, const std::filesystem::path& folder,
                       const ResultPlace& place, const Progress& progress);

}  // namespace sim::bench
