// What the plans of scenarios ask of the whole body: error of its ZMP with and without the second preview
// stage, and its yaw momentum with each motion of the arms. Nothing is simulated. Usage: plan_report
// SCENARIO...
#include <cmath>
#include <cstdio>
#include <exception>
#include <vector>

#include "sim/bench/scenario.h"
#include "sim/world/nominal_body.h"
#include "walking/pattern_generator.h"

namespace {

using Eigen::Vector2d;

struct Spread {
  double square = 0, largest = 0;
  int n = 0;

  void add(double value) {
    square += value * value;
    largest = std::max(largest, std::abs(value));
    ++n;
  }
  double rms() const { return n == 0 ? 0 : std::sqrt(square / n); }
};

struct Report {
  Spread zmp_ahead, zmp_aside;      // of reference minus the whole body's, waist axes, m
  Spread yaw_momentum, yaw_moment;  // about the centre of mass, kg m²/s and N·m
};

/// Plays the plan through the model: momenta half-way between ticks, ZMP and moments at the ticks.
Report report(const walking::WalkOptions& options, const walking::WholeBody& body) {
  walking::PatternGenerator plan(options, body);
  Report report;
  walking::Reference before = plan.next(), now = plan.next();
  walking::BodyMomentum first = body(walking::motion_between(pose_of(before), pose_of(now)));
  for (std::size_t k = 2; k < plan.ticks(); ++k) {
    const walking::Reference after = plan.next();
    const walking::BodyMomentum second = body(walking::motion_between(pose_of(now), pose_of(after)));
    const Vector2d error = now.zmp_reference - walking::multibody_zmp(first, second);
    const Vector2d in_waist = now.X_PB.linear().topLeftCorner<2, 2>().transpose() * error;
    report.zmp_ahead.add(in_waist.x());
    report.zmp_aside.add(in_waist.y());
    report.yaw_momentum.add(second.angular.z());
    report.yaw_moment.add((second.angular.z() - first.angular.z()) / walking::kPeriod);
    now = after;
    first = second;
  }
  return report;
}

void print(const char* arms, bool second_preview, const Report& r) {
  std::printf("  %-9s %-6s  %5.1f %5.1f  %5.1f %5.1f    %6.3f %6.3f  %6.2f %6.2f\n", arms,
              second_preview ? "two" : "one", 1e3 * r.zmp_ahead.rms(), 1e3 * r.zmp_ahead.largest,
              1e3 * r.zmp_aside.rms(), 1e3 * r.zmp_aside.largest, r.yaw_momentum.rms(),
              r.yaw_momentum.largest, r.yaw_moment.rms(), r.yaw_moment.largest);
}

void report(const char* file) {
  const auto scenario = sim::bench::read_scenario(file).scenario;
  const walking::WholeBody body = sim::world::nominal_body(scenario.world.robot, GAITSLAM_MODELS);
  std::printf("%s\n  arms      stages  ZMP error, mm: ahead, aside  yaw momentum, kg m²/s; moment, N·m\n",
              scenario.name.c_str());
  std::printf("                      rms   max    rms   max       rms    max     rms    max\n");
  using enum walking::ArmMotion;
  for (const auto& [arms, name] : {std::pair(still, "still"), {swing, "swing"}, {momentum, "momentum"}}) {
    for (const bool second_preview : {false, true}) {
      walking::WalkOptions walk = scenario.walk;
      walk.arm_motion = arms;
      walk.second_preview = second_preview;
      print(name, second_preview, report(walk, body));
    }
  }
}

}  // namespace

int main(int count, char** arguments) try {
  for (int i = 1; i < count; ++i) report(arguments[i]);
  return count > 1 ? 0 : 2;
} catch (const std::exception& e) {
  std::fprintf(stderr, "plan_report: %s\n", e.what());
  return 2;
}
