// The simulator as the program uses it: live_world.cc, or live_stub.cc in a build without the simulator.
#pragma once

#include "sim/result/result.h"
#include "sim/scenario/scenario.h"
#include "tools/cli/shared/terminal.h"
#include "walking/kinematics.h"

namespace sim::live {
struct RunObserver;
}

namespace cli {

/// live::run, or UsageError in a build without the simulator. observer: may be null.
result::Outcome run_live(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                         const result::Progress& progress, int threads = 1,
                         const live::RunObserver* observer = nullptr);

/// Throws UsageError in a build without the simulator. Call it before anything is started.
void require_simulator();

/// live::require_clear_walk; returns false without the simulator.
bool require_clear_walk(const scenario::ReadScenario& read, const fs::path& models);

/// The robot's model for the plan; empty without the simulator. Throws std::runtime_error.
walking::WholeBody whole_body(const scenario::Scenario& scenario, const fs::path& models);

/// MuJoCo's version, or "" without the simulator.
std::string mujoco_version();

}  // namespace cli
