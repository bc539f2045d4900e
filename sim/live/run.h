// The live loop: plan, stabilizer, physics, camera, recording and filter, one simulated millisecond after
// another.
#pragma once

#include <filesystem>

#include "sim/live/run_observer.h"
#include "sim/result/result.h"
#include "sim/scenario/scenario.h"

namespace sim::live {

/// Walks the scenario and leaves a complete result folder, whatever the ending.
/// place: where models lie and results go. threads: 2 draws images beside the walk; the result is the same,
/// and so it is with any observer. Throws std::invalid_argument or std::runtime_error when the scenario
/// cannot be begun (a walk that cannot be planned, a model that does not load, a folder that cannot be
/// written) and ConfigError when the planned walk is not clear of its room; then no folder is left behind.
result::Outcome run(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                    const result::Progress& progress, int threads = 1, const RunObserver& observer = {});

}  // namespace sim::live
