// Measures the libraries' CPU time (ms) in a scenario's walk: a MuJoCo step and a picture drawn by OSMesa.
// Usage: library_bench SCENARIO MODELS
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/camera/head_camera.h"
#include "sim/live/setup.h"
#include "sim/physics/walking_robot.h"
#include "sim/result/result.h"
#include "sim/scenario/robot.h"

namespace {

using namespace sim;

constexpr std::chrono::seconds kWalk{10};

/// Steps a copy of the robot's state once per tick and draws it at 25 Hz.
void bench(const scenario::ReadScenario& read, const std::string& models_folder) {
  const scenario::Scenario& s = read.scenario;
  const physics::Models models(scenario::read_robot(s), s.world.room, models_folder);
  physics::WalkingRobot robot(live::clear_plan(read, models), s.stabilizer, s.world, {}, models);
  camera::HeadCamera camera(physics::copy_of(models.in_room), s.camera.value(), s.world.seed);
  const mjModel& model = *robot.world().model();
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(&model), mj_deleteData);
  double step_ms = 0, draw_ms = 0;
  int ticks = 0, pictures = 0;
  for (; robot.walks() && robot.world().time() < kWalk; robot.tick(), ++ticks) {
    mj_copyData(data.get(), &model, robot.world().data());
    {
      const result::StageClock clock(step_ms);
      mj_step(&model, data.get());
    }
    if (ticks % 8 != 0) continue;
    camera::RecentMotion motion(walking::kTick);
    motion.add(robot.world().time(), model, *robot.world().data());
    const result::StageClock clock(draw_ms);
    camera.expose(motion, robot.world().time(), {});
    ++pictures;
  }
  fmt::print("{{\"step_ms\": {:.5f}, \"picture_ms\": {:.5f}}}\n", step_ms / ticks, draw_ms / pictures);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return fmt::print(stderr, "usage: library_bench SCENARIO MODELS\n"), 2;
  try {
    bench(scenario::read_scenario(argv[1]), argv[2]);
  } catch (const std::exception& problem) {
    return fmt::print(stderr, "library_bench: {}\n", problem.what()), 2;
  }
  return 0;
}
