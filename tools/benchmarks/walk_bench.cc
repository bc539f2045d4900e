// Walks of a scenario without camera and filter: how far they drift from the plan, how well the robot keeps
// its balance, and how fast plan, control and physics run, on CPU time of one core. Usage: walk_bench [--from
// X_M,Y_M,HEADING_DEG] SCENARIO [LAST_SEED [KEY=VALUE]...]
// --from: where on the floor the walk begins; the drift is told as seen from there.
#include <mujoco/mujoco.h>
#include <time.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <numbers>
#include <string_view>
#include <vector>

#include "sim/bench/draw.h"
#include "sim/bench/scenario.h"
#include "sim/world/nominal_body.h"
#include "sim/world/world.h"
#include "walking/inverse_kinematics.h"
#include "walking/pattern_generator.h"
#include "walking/stabilizer.h"

namespace {

using sim::world::Condition;

constexpr double kDegrees = 180 / std::numbers::pi;

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

Drift walk(const sim::bench::Scenario& scenario, std::uint64_t seed, const Eigen::Isometry3d& X_WP,
           Profile& profile, Balance& balance) {
  walking::PatternGenerator generator = timed(profile.plan, [&] {
    return walking::PatternGenerator(scenario.walk,
                                     sim::world::nominal_body(scenario.world.robot, GAITSLAM_MODELS));
  });
  walking::Stabilizer stabilizer(scenario.stabilizer);
  walking::Reference reference = generator.next();
  walking::JointVector q = walking::inverse_kinematics(walking::posture_of(reference)).q;
  sim::world::World world(scenario.world, sim::bench::draw(seed, scenario.world), q, X_WP * reference.X_PB,
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
  const Eigen::Isometry3d X_PB = X_WP.inverse() * world.X_WB();
  const Eigen::Vector3d drift = 1e3 * (X_PB.translation() - reference.X_PB.translation());
  const double turn = std::remainder(heading(X_PB) - heading(reference.X_PB), 2 * std::numbers::pi);
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
  const auto scenario = sim::bench::read_scenario(arguments[1], {overrides, {"camera", "slam"}}).scenario;
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
