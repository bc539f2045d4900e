#include <mujoco/mujoco.h>

#include "sim/bench/run.h"
#include "sim/world/nominal_body.h"
#include "tools/cli/live.h"

namespace cli {

sim::bench::Outcome run_live(const sim::bench::ReadScenario& scenario, const sim::bench::ResultPlace& place,
                             const sim::bench::Progress& progress) {
  return sim::bench::run(scenario, place, progress);
}

void require_simulator() {}

walking::WholeBody whole_body(const sim::bench::Scenario& scenario, const std::filesystem::path& models) {
  return sim::world::nominal_body(scenario.world.robot, models);
}

std::string mujoco_version() { return mj_versionString(); }

}  // namespace cli
