// The simulator as the program uses it: implemented by live_world.cc in the full build, by live_stub.cc in a
// build without the simulator.
#pragma once

#include <string>

#include "sim/result/result.h"
#include "sim/scenario/scenario.h"
#include "walking/kinematics.h"

namespace sim::live {
struct RunObserver;
}

namespace cli {

/// sim::live::run, or UsageError in a build without the simulator. observer: may be null.
sim::result::Outcome run_live(const sim::scenario::ReadScenario& scenario,
                              const sim::result::ResultPlace& place, const sim::result::Progress& progress,
                              int threads = 1, const sim::live::RunObserver* observer = nullptr);

/// Throws UsageError in a build without the simulator. Call it before anything is started.
void require_simulator();

/// sim::live::require_clear_walk; returns false without the simulator.
bool require_clear_walk(const sim::scenario::ReadScenario& read, const std::filesystem::path& models);

/// The model of the scenario's robot for the plan; empty without the simulator. Throws std::runtime_error
/// when it cannot be loaded.
walking::WholeBody whole_body(const sim::scenario::Scenario& scenario, const std::filesystem::path& models);

/// MuJoCo's version, or "" without the simulator.
std::string mujoco_version();

}  // namespace cli
