// The program's interface to the simulator: live_world.cc, or live_stub.cc in a build without the simulator.
#pragma once

#include "sim/result/result.h"
#include "tools/cli/shared/terminal.h"
#include "walking/pattern_generator.h"

namespace sim::live {
struct RunObserver;
}

namespace cli {

/// Returns the outcome of live::run. Throws UsageError in a build without the simulator. observer: may be
/// null.
result::Outcome run_live(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                         const result::Progress& progress, int threads = 1,
                         const live::RunObserver* observer = nullptr);

/// Throws UsageError in a build without the simulator. Call it before anything is started.
void require_simulator();

/// Returns the plan from live::check, or nullopt without the simulator. Throws what live::check throws.
std::optional<walking::PatternGenerator> check_start(const scenario::ReadScenario& read,
                                                     const fs::path& models);

/// Returns MuJoCo's version, or "" without the simulator.
std::string mujoco_version();

}  // namespace cli
