// The filter again on a recording: no physics, no rendering, the same bits.
#pragma once

#include <filesystem>
#include <string>

#include "sim/bench/result.h"
#include "sim/bench/scenario.h"

namespace sim::bench {

/// How a recorded walk ended, and why if not well.
struct WalkEnd {
  std::string ending, cause;
};

/// Of the run whose result folder it is, by its about.json. Throws FileError.
WalkEnd read_walk_end(const std::filesystem::path& result_folder);

/// Whether a replay leaves a copy of the recording in its result, as a run does.
enum class Recorded { left_out, copied };

/// Runs the filter of `scenario`, if it has one, on `recording` and leaves a complete result folder: but for
/// timing.*, the bytes that a run of the scenario leaves, recording/ if that is asked for. Truth is opened
/// after the filter is done. Throws FileError when the recording is not as it was written, or ResultPlace
/// cannot be written.
Outcome replay(const ReadScenario& scenario, const std::filesystem::path& recording, const WalkEnd& walk,
               const ResultPlace& place, const Progress& progress, Recorded recorded = Recorded::left_out);

}  // namespace sim::bench
