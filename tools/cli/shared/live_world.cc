#include <mujoco/mujoco.h>

#include "sim/live/recorded.h"
#include "sim/live/run.h"
#include "sim/physics/nominal_body.h"
#include "tools/cli/shared/live.h"

namespace cli {

sim::result::Outcome run_live(const sim::scenario::ReadScenario& scenario,
                              const sim::result::ResultPlace& place, const sim::result::Progress& progress,
                              int threads, const sim::live::RunObserver* observer) {
  return sim::live::run(scenario, place, progress, threads, observer ? *observer : sim::live::RunObserver{});
}

void require_simulator() {}

bool require_clear_walk(const sim::scenario::ReadScenario& read, const std::filesystem::path& models) {
  const sim::physics::WorldOptions& world = read.scenario.world;
  sim::live::clear_plan(read, {world.robot, world.room, models});
  return true;
}

walking::WholeBody whole_body(const sim::scenario::Scenario& scenario, const std::filesystem::path& models) {
  return sim::physics::nominal_body(scenario.world.robot, models);
}

std::string mujoco_version() { return mj_versionString(); }

}  // namespace cli
