// How fast plan, control and physics run without camera and filter, and where their time goes: the tangent
// circle on CPU time of one core. Usage: walk_bench [last seed]
#include <time.h>

#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "sim/bench/draw.h"
#include "sim/world/world.h"
#include "walking/inverse_kinematics.h"
#include "walking/pattern_generator.h"
#include "walking/stabilizer.h"

namespace {

using sim::world::Condition;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Adds the CPU time that `work` takes to `total`.
template <typename Work>
auto timed(double& total, const Work& work) {
  const double begin = cpu_seconds();
  auto result = work();
  total += cpu_seconds() - begin;
  return result;
}

struct Profile {
  double simulated = 0, plan = 0, control = 0, physics = 0;
};

walking::WalkOptions tangent_circle() {
  walking::WalkOptions walk;
  walk.commands = {walking::Stand{1}, walking::Straight{1.0, -0.5}};
  for (int arc = 0; arc < 4; ++arc) {
    walk.commands.insert(walk.commands.end(), {walking::Stand{1}, walking::TangentArc{}});
  }
  walk.commands.push_back(walking::Stand{1});
  return walk;
}

Condition walk(std::uint64_t seed, Profile& profile) {
  const sim::world::WorldOptions options;
  walking::PatternGenerator generator =
      timed(profile.plan, [] { return walking::PatternGenerator(tangent_circle()); });
  walking::Stabilizer stabilizer;
  walking::Reference reference = generator.next();
  walking::JointVector q = walking::inverse_kinematics(walking::posture_of(reference)).q;
  sim::world::World world(options, sim::bench::draw(seed, options), q, reference.X_PB, GAITSLAM_MODELS);
  for (std::size_t tick = 0; tick < generator.ticks() && world.status().condition == Condition::ok; ++tick) {
    const walking::JointVector next = timed(profile.control, [&] {
      return walking::inverse_kinematics(stabilizer.step(reference, world.felt())).q;
    });
    world.command(next, (next - q) / walking::kPeriod);
    q = next;
    timed(profile.physics, [&] {
      for (int k = 0; k < 5; ++k) world.step();
      return 0;
    });
    reference = timed(profile.plan, [&] { return generator.next(); });
    profile.simulated += walking::kPeriod;
  }
  const Eigen::Vector3d drift = world.X_WB().translation() - reference.X_PB.translation();
  std::printf("seed %lu: %s, drift of the waist %.0f mm %.0f mm\n", static_cast<unsigned long>(seed),
              world.status().condition == Condition::ok ? "walked" : world.status().cause.c_str(),
              1e3 * drift.x(), 1e3 * drift.y());
  return world.status().condition;
}

}  // namespace

int main(int count, char** arguments) {
  const int last = count > 1 ? std::atoi(arguments[1]) : 1;
  Profile profile;
  int fallen = 0;
  for (int seed = 1; seed <= last; ++seed)
    fallen += walk(static_cast<std::uint64_t>(seed), profile) != Condition::ok;
  const double total = profile.plan + profile.control + profile.physics;
  std::printf(
      "%.1f x real time on one core: plan %.1f %%, control %.1f %%, physics %.1f %%; %d of %d not walked\n",
      profile.simulated / total, 100 * profile.plan / total, 100 * profile.control / total,
      100 * profile.physics / total, fallen, last);
  return fallen == 0 ? 0 : 1;
}
