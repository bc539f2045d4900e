#include <mujoco/mujoco.h>

#include <algorithm>
#include <iostream>

#include "sim/live/run.h"
#include "sim/scenario/robot.h"
#include "tools/cli/shared/live.h"

namespace cli {
namespace {

constexpr float kDark = 0.3f;  // ambient light

}  // namespace

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
  if (read.scenario.camera && read.scenario.world.room.is_path()) {
    const physics::Model in_room = physics::load_model(scenario::read_robot(read.scenario), room, models);
    const float ambient = in_room->vis.headlight.active ? in_room->vis.headlight.ambient[0] : 0;
    if (std::none_of(in_room->light_active, in_room->light_active + in_room->nlight,
                     [](mjtByte on) { return on; }) &&
        ambient < kDark)
      std::cerr << fmt::format(
          "warning: world.room: {} has no light, so images are almost black, expected lights with "
          "directional=\"true\", or <visual><headlight ambient=\"0.6 0.6 0.6\" diffuse=\"0 0 "
          "0\"/></visual>\n",
          room);
  }
  return plan;
}

std::string mujoco_version() { return mj_versionString(); }

}  // namespace cli
