// Walks of a scenario without camera and filter: how well the robot keeps its balance, and how fast plan,
// control and physics run, on CPU time of one core. Usage: walk_bench SCENARIO [LAST_SEED [KEY=VALUE]...]
#include <mujoco/mujoco.h>
#include <time.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <numbers>

#include "sim/bench/draw.h"
#include "sim/bench/scenario.h"
#include "sim/world/nominal_body.h"
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
  std::array<double, mjNTIMER> stage{};  // of the physics, as MuJoCo times itself, s
};

/// What MuJoCo times its stages by.
mjtNum microseconds() {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// Sums over all ticks of all walks; tilt is true, the capture point's error is the one felt.
struct Balance {
  int ticks = 0, fallen = 0;
  double tilt_squared = 0, largest_tilt = 0, capture_point_squared = 0;
};

void weigh(const sim::world::World& world, const walking::StabilizerState& felt, Balance& balance) {
  constexpr double kOmega = 3.4838;  // 1/s, of the half-sitting robot's pendulum
  const double tilt = std::acos(std::min(1.0, world.X_WB().linear()(2, 2)));
  ++balance.ticks;
  balance.tilt_squared += tilt * tilt;
  balance.largest_tilt = std::max(balance.largest_tilt, tilt);
  balance.capture_point_squared += (felt.com_error + felt.com_velocity_error / kOmega).squaredNorm();
}

double heading(const Eigen::Isometry3d& X) { return std::atan2(X.linear()(1, 0), X.linear()(0, 0)); }

void walk(const sim::bench::Scenario& scenario, std::uint64_t seed, Profile& profile, Balance& balance) {
  walking::PatternGenerator generator = timed(profile.plan, [&] {
    return walking::PatternGenerator(scenario.walk,
                                     sim::world::nominal_body(scenario.world.robot, GAITSLAM_MODELS));
  });
  walking::Stabilizer stabilizer(scenario.stabilizer);
  walking::Reference reference = generator.next();
  walking::JointVector q = walking::inverse_kinematics(walking::posture_of(reference)).q;
  sim::world::World world(scenario.world, sim::bench::draw(seed, scenario.world), q, reference.X_PB,
                          GAITSLAM_MODELS);
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
    weigh(world, stabilizer.state(), balance);
    reference = timed(profile.plan, [&] { return generator.next(); });
    profile.simulated += walking::kPeriod;
  }
  for (int i = 0; i < mjNTIMER; ++i) profile.stage[i] += 1e-6 * world.data()->timer[i].duration;
  const bool walked = world.status().condition == Condition::ok;
  balance.fallen += walked ? 0 : 1;
  const Eigen::Vector3d drift = 1e3 * (world.X_WB().translation() - reference.X_PB.translation());
  const double turn = std::remainder(heading(world.X_WB()) - heading(reference.X_PB), 2 * std::numbers::pi);
  std::printf("seed %lu: %s, drift of the waist %.0f mm, %.0f mm, %.1f deg\n",
              static_cast<unsigned long>(seed), walked ? "walked" : world.status().cause.c_str(), drift.x(),
              drift.y(), turn * 180 / std::numbers::pi);
}

void print(int walks, const Balance& balance, const Profile& profile) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  std::printf("%d of %d fell; tilt rms %.2f deg, largest %.2f deg; capture point error rms %.1f mm\n",
              balance.fallen, walks, kDegrees * std::sqrt(balance.tilt_squared / balance.ticks),
              kDegrees * balance.largest_tilt,
              1e3 * std::sqrt(balance.capture_point_squared / balance.ticks));
  const double total = profile.plan + profile.control + profile.physics;
  std::printf("%.1f x real time on one core: plan %.1f %%, control %.1f %%, physics %.1f %%\n",
              profile.simulated / total, 100 * profile.plan / total, 100 * profile.control / total,
              100 * profile.physics / total);
  constexpr std::array<std::pair<const char*, int>, 6> kStages{{{"constraint solver", mjTIMER_CONSTRAINT},
                                                                {"constraint Jacobian", mjTIMER_POS_MAKE},

                                                                {"collision", mjTIMER_POS_COLLISION},
                                                                {"kinematics", mjTIMER_POS_KINEMATICS},
                                                                {"inertia", mjTIMER_POS_INERTIA},
                                                                {"velocity", mjTIMER_VELOCITY}}};
  double all = 0;
  for (int stage = mjTIMER_POSITION; stage <= mjTIMER_CONSTRAINT; ++stage) all += profile.stage[stage];
  std::printf("of the physics:");
  for (const auto& [name, stage] : kStages)
    std::printf(" %s %.0f %%", name, 100 * profile.stage[stage] / all);
  std::printf("\n");
}

}  // namespace

int main(int count, char** arguments) try {
  if (count < 2) throw std::runtime_error("usage: walk_bench SCENARIO [LAST_SEED [KEY=VALUE]...]");
  const int walks = count > 2 ? std::atoi(arguments[2]) : 1;
  if (walks < 1) throw std::runtime_error("the last seed must be 1 or more");
  const std::vector<std::string> overrides(arguments + std::min(count, 3), arguments + count);
  const auto scenario = sim::bench::read_scenario(arguments[1], {overrides, {"camera", "slam"}}).scenario;
  mjcb_time = microseconds;
  Profile profile;
  Balance balance;
  for (int seed = 1; seed <= walks; ++seed)
    walk(scenario, static_cast<std::uint64_t>(seed), profile, balance);
  print(walks, balance, profile);
  return balance.fallen == 0 ? 0 : 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "walk_bench: %s\n", e.what());
  return 2;
}
