#include <mujoco/mujoco.h>

#include <iostream>

#include "sim/live/run.h"
#include "sim/scenario/robot.h"
#include "tools/cli/shared/live.h"

namespace cli {

result::Outcome run_live(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                         const result::Progress& progress, int threads, const live::RunObserver* observer) {
  return live::run(scenario, place, progress, threads, observer ? *observer : live::RunObserver{});
}

void require_simulator() {}

std::optional<walking::PatternGenerator> check_start(const scenario::ReadScenario& read,
                                                     const fs::path& models) {
  const auto plan = live::check(read, models);
  const std::string& room = read.scenario.world.room;
  const physics::Model on_floor =
      physics::load_model(scenario::read_robot(read.scenario), room, models, physics::Shapes::floor);
  if (const std::size_t solids = physics::Floor(*on_floor).solids(); solids > physics::kMostSolids)
    std::cerr << fmt::format(
        "warning: world.room: the robot steps on {} shapes of {}, which slows down the physics; expected at "
        "most {}, or a height field\n",
        solids, room, physics::kMostSolids);
  return plan;
}

std::string mujoco_version() { return mj_versionString(); }

}  // namespace cli
