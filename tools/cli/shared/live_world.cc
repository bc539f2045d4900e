#include <mujoco/mujoco.h>

#include "sim/live/run.h"
#include "sim/live/setup.h"
#include "tools/cli/shared/live.h"

namespace cli {

result::Outcome run_live(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                         const result::Progress& progress, int threads, const live::RunObserver* observer) {
  return live::run(scenario, place, progress, threads, observer ? *observer : live::RunObserver{});
}

void require_simulator() {}

std::optional<walking::PatternGenerator> clear_plan(const scenario::ReadScenario& read,
                                                    const fs::path& models) {
  const physics::WorldOptions& world = read.scenario.world;
  physics::Models loaded(world.robot, world.room, models);
  walking::PatternGenerator plan = live::clear_plan(read, loaded);
  live::mount_sensors(read, loaded);
  return plan;
}

std::string mujoco_version() { return mj_versionString(); }

}  // namespace cli
