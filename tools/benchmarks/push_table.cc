// The largest push that the robot survives, in four directions, standing and walking, with and without its
// stabiliser: a table in markdown. Usage: push_table
#include <cstdio>
#include <numbers>

#include "sim/world/world.h"
#include "walking/inverse_kinematics.h"
#include "walking/pattern_generator.h"
#include "walking/stabilizer.h"

namespace {

using sim::world::Condition, sim::world::Push;

constexpr double kLargest = 64, kResolution = 1;  // N s

struct Trial {
  const char* name;
  bool stabilizer = true;
  std::vector<walking::Command> commands;
  double time_s = 2;
};

bool survives(const Trial& trial, const Push& push) {
  walking::WalkOptions walk;
  walk.commands = trial.commands;
  walking::StabilizerOptions options;
  options.enabled = trial.stabilizer;
  walking::PatternGenerator generator(walk);
  walking::Stabilizer stabilizer(options);
  walking::Reference reference = generator.next();
  walking::JointVector q = walking::inverse_kinematics(walking::posture_of(reference)).q;
  sim::world::WorldOptions world_options;
  world_options.pushes = {push};
  sim::world::World world(world_options, {}, q, reference.X_PB, GAITSLAM_MODELS);
  for (std::size_t tick = 0; tick < generator.ticks() && world.status().condition == Condition::ok; ++tick) {
    const walking::JointVector next = walking::inverse_kinematics(stabilizer.step(reference, world.felt())).q;
    world.command(next, (next - q) / walking::kPeriod);
    q = next;
    for (int k = 0; k < 5; ++k) world.step();
    reference = generator.next();
  }
  return world.status().condition == Condition::ok;
}

/// By halving: a push it survives, and one kResolution more that it does not.
double largest_survived(const Trial& trial, double direction) {
  const auto stands = [&](double impulse) {
    return survives(trial, {.time_s = trial.time_s, .impulse_ns = impulse, .direction_rad = direction});
  };
  double survived = 0, fallen = kLargest;
  if (!stands(0)) return -1;
  while (fallen - survived > kResolution) {
    const double impulse = (survived + fallen) / 2;
    (stands(impulse) ? survived : fallen) = impulse;
  }
  return survived;
}

}  // namespace

int main() {
  using walking::Stand, walking::Straight;
  // 3.66 s: the middle of the third single support of the walk, on the left foot.
  const Trial trials[]{{"standing, stabiliser on", true, {Stand{6}}, 2},
                       {"standing, off", false, {Stand{6}}, 2},
                       {"walking, stabiliser on", true, {Stand{0}, Straight{0.9, 0}}, 3.66},
                       {"walking, off", false, {Stand{0}, Straight{0.9, 0}}, 3.66}};
  std::printf(
      "| largest push survived, N s in 0.1 s | ahead | left | back | right |\n|---|---|---|---|---|\n");
  for (const Trial& trial : trials) {
    std::printf("| %s |", trial.name);
    for (int side = 0; side < 4; ++side) {
      const double impulse = largest_survived(trial, side * std::numbers::pi / 2);
      impulse < 0 ? std::printf(" falls unpushed |") : std::printf(" %.0f |", impulse);
      std::fflush(stdout);
    }
    std::printf("\n");
  }
  return 0;
}
