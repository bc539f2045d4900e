#include <mujoco/mujoco.h>

#include "sim/live/recorded.h"
#include "sim/live/run.h"
#include "sim/physics/nominal_body.h"
#include "tools/cli/shared/live.h"

namespace cli {

result::Outcome run_live(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                         const result::Progress& progress, int threads, const live::RunObserver* observer) {
  return live::run(scenario, place, progress, threads, observer ? *observer : live::RunObserver{});
}

void require_simulator() {}

bool require_clear_walk(const scenario::ReadScenario& read, const fs::path& models) {
  const physics::WorldOptions& world = read.scenario.world;
  physics::Models loaded(world.robot, world.room, models);
  live::clear_plan(read, loaded);
  live::mount_sensors(read, loaded);
  return true;
}

walking::WholeBody whole_body(const scenario::Scenario& scenario, const fs::path& models) {
  return physics::nominal_body(scenario.world.robot, models);
}

std::string mujoco_version() { return mj_versionString(); }

}  // namespace cli
