// Walks of a scenario without camera and filter: how far they drift from the plan, how well the robot keeps
// its balance, and how fast plan, control and physics run, on CPU time of one core. Usage: walk_bench [--from
// X_M,Y_M,HEADING_DEG] SCENARIO [LAST_SEED [KEY=VALUE]...]
// --from: where on the floor the walk begins; the drift is given in the frame of that start.
#include <mujoco/mujoco.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/live/plant_variation.h"
#include "sim/physics/nominal_body.h"
#include "sim/physics/walking_robot.h"
#include "sim/scenario/scenario.h"
#include "tools/benchmarks/cpu_time.h"

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

/// Adds the CPU time that `work` takes to `total`, s.
template <typename Work>
auto timed(double& total, const Work& work) {
  const double begin_ms = cpu_ms();
  auto result = work();
  total += 1e-3 * (cpu_ms() - begin_ms);
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

/// Sums over all ticks of all walks; the tilt is true, the capture point's error is the stabiliser's
/// estimate.
struct Balance {
  int ticks = 0, fallen = 0;
  double tilt_squared = 0, largest_tilt = 0, capture_point_squared = 0;
};

void add(const sim::physics::WalkingRobot& robot, Balance& balance) {
  const double tilt = std::acos(std::min(1.0, robot.world().X_WB().linear()(2, 2)));
  ++balance.ticks;
  balance.tilt_squared += tilt * tilt;
  balance.largest_tilt = std::max(balance.largest_tilt, tilt);
  balance.capture_point_squared += robot.stabilizer().capture_point_error().squaredNorm();
}

double heading(const Eigen::Isometry3d& X) { return std::atan2(X.linear()(1, 0), X.linear()(0, 0)); }

/// Where the plan's world P is: "50,-30,115" is 50 m ahead, 30 m to the right, turned by 115 deg to the left.
Eigen::Isometry3d start(const char* text) {
  double x = 0, y = 0, degrees = 0;
  char more = 0;
  if (std::sscanf(text, "%lf,%lf,%lf%c", &x, &y, &degrees, &more) != 3)
    throw std::runtime_error(std::string("--from ") + text + ": expected X_M,Y_M,HEADING_DEG");
  const Eigen::AngleAxisd turn(degrees / kDegrees, Eigen::Vector3d::UnitZ());
  return Eigen::Translation3d(x, y, 0) * turn;
}

/// In x and y, mm, and in yaw, deg; as seen from the start.
using Drift = Eigen::Array3d;

Drift walk(const sim::scenario::Scenario& scenario, std::uint64_t seed, const Eigen::Isometry3d& X_WP,
           Profile& profile, Balance& balance) {
  walking::PatternGenerator plan = timed(profile.plan, [&] {
    return walking::PatternGenerator(scenario.walk,
                                     sim::physics::nominal_body(scenario.world.robot, GAITSLAM_MODELS));
  });
  sim::physics::WalkingRobot robot(std::move(plan), scenario.stabilizer, scenario.world,
                                   sim::live::plant_variation(seed, scenario.world), GAITSLAM_MODELS, X_WP);
  sim::physics::World& world = robot.world();
  while (robot.walks()) {
    timed(profile.control, [&] { return robot.command(world.sensor_readings()), 0; });
    timed(profile.physics, [&] {
      const auto end = world.time() + walking::kTick;
      while (robot.is_ok() && world.time() < end) world.step();
      return 0;
    });
    add(robot, balance);
    timed(profile.plan, [&] { return robot.advance(), 0; });
    profile.simulated += walking::kPeriod;
  }
  for (int i = 0; i < mjNTIMER; ++i) profile.stage[i] += 1e-6 * world.data()->timer[i].duration;
  const bool walked = robot.is_ok();
  balance.fallen += walked ? 0 : 1;
  const Eigen::Isometry3d X_PB = X_WP.inverse() * world.X_WB(), &planned = robot.reference().X_PB;
  const Eigen::Vector3d drift = 1e3 * (X_PB.translation() - planned.translation());
  const double turn = std::remainder(heading(X_PB) - heading(planned), 2 * std::numbers::pi);
  std::printf("seed %lu: %s, drift of the waist %.0f mm, %.0f mm, %.1f deg\n",
              static_cast<unsigned long>(seed), walked ? "walked" : world.status().cause.c_str(), drift.x(),
              drift.y(), turn * kDegrees);
  return {drift.x(), drift.y(), turn * kDegrees};
}

void print(const std::vector<Drift>& drifts) {
  Drift mean = Drift::Zero(), square = Drift::Zero();
  const auto count = static_cast<double>(drifts.size());
  for (const Drift& drift : drifts) mean += drift / count;
  for (const Drift& drift : drifts) square += (drift - mean).square();
  const Drift sd = (square / std::max(1.0, count - 1)).sqrt();
  std::printf("drift, mean (sd): %.0f mm (%.0f), %.0f mm (%.0f), %.1f deg (%.1f)\n", mean.x(), sd.x(),
              mean.y(), sd.y(), mean.z(), sd.z());
}

void print(int walks, const Balance& balance, const Profile& profile) {
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
  Eigen::Isometry3d X_WP = Eigen::Isometry3d::Identity();
  if (count > 2 && std::string_view(arguments[1]) == "--from") {
    X_WP = start(arguments[2]);
    count -= 2, arguments += 2;
  }
  if (count < 2)
    throw std::runtime_error(
        "usage: walk_bench [--from X_M,Y_M,HEADING_DEG] SCENARIO [LAST_SEED [KEY=VALUE]...]");
  const int walks = count > 2 ? std::atoi(arguments[2]) : 1;
  if (walks < 1) throw std::runtime_error("the last seed must be 1 or more");
  const std::vector<std::string> overrides(arguments + std::min(count, 3), arguments + count);
  const auto scenario = sim::scenario::read_scenario(arguments[1], {overrides, {"camera", "slam"}}).scenario;
  mjcb_time = microseconds;
  Profile profile;
  Balance balance;
  std::vector<Drift> drifts;
  for (int seed = 1; seed <= walks; ++seed)
    drifts.push_back(walk(scenario, static_cast<std::uint64_t>(seed), X_WP, profile, balance));
  print(drifts);
  print(walks, balance, profile);
  return balance.fallen == 0 ? 0 : 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "walk_bench: %s\n", e.what());
  return 2;
}
