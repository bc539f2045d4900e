// Runs the filter on a recording, without physics and rendering, with the same result as in the live run.
#pragma once

#include <filesystem>
#include <string>

#include "sim/result/result.h"
#include "sim/scenario/scenario.h"
#include "sim/tracking/tracking_observer.h"

namespace sim::replay {

/// How a recorded walk ended, and the cause if it was not completed.
struct WalkEnd {
  std::string ending, cause;
  /// Why the filter that is replayed would have steered another walk; empty if it would not.
  std::string counterfactual = {};
  std::string models_hash = {};  ///< of the models that the walk was simulated with; empty: unknown
};

/// Reads the walk's end from the about.json of a result folder. Throws FileError.
WalkEnd read_walk_end(const std::filesystem::path& result_folder);

/// Whether a replay copies the recording into its result, as a run does.
enum class Recorded { left_out, copied };

/// Runs the filter of `scenario`, if it has one, on `recording` and writes a complete result folder: the same
/// bytes as a run of the scenario, except timing.* and, unless copied, recording/. Truth is opened after the
/// filter is done. Throws FileError if the recording was changed after it was written, or if `place` cannot
/// be written.
result::Outcome replay(const scenario::ReadScenario& scenario, const std::filesystem::path& recording,
                       const WalkEnd& walk, const result::ResultPlace& place,
                       const result::Progress& progress, Recorded recorded = Recorded::left_out,
                       const tracking::TrackingObserver& observer = {});

}  // namespace sim::replay
