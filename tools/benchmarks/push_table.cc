// The largest push that the robot survives, in four directions, standing and walking, with and without its
// stabiliser: a table in markdown. Usage: push_table
#include <cstdio>
#include <numbers>

#include "sim/physics/walking_robot.h"

namespace {

using sim::physics::Push;

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
  sim::physics::WorldOptions world;
  world.pushes = {push};
  sim::physics::WalkingRobot robot(walking::PatternGenerator(walk), options, world, {}, GAITSLAM_MODELS);
  while (robot.walks()) robot.tick();
  return robot.is_ok();
}

/// Bisection between a push that the robot survives and one that it does not, to kResolution. Negative if it
/// falls without a push.
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
