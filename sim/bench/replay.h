// The filter again on a recording: no physics, no rendering, the same bits.
#pragma once

#include <filesystem>

#include "sim/bench/result.h"
#include "sim/bench/scenario.h"

namespace sim::bench {

/// Runs the filter of `scenario` on `recording` and leaves a complete result folder (without a copy of the
/// recording). walk_ending: how the recorded walk ended. Truth is opened after the filter is done. Throws
/// FileError when the recording is not as it was written, or ResultPlace cannot be written.
Outcome replay(const ReadScenario& scenario, const std::filesystem::path& recording,
               const std::string& walk_ending, const ResultPlace& place, const Progress& progress);

}  // namespace sim::bench
