// The plans of scenarios on the multibody model: error of its ZMP with and without the second preview stage,
// and its yaw momentum with each motion of the arms. Nothing is simulated. Usage: plan_report SCENARIO...
#include <cmath>
#include <cstdio>
#include <exception>
#include <vector>

#include "sim/physics/nominal_body.h"
#include "sim/scenario/scenario.h"
#include "tools/benchmarks/play_plan.h"

namespace {

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

Report report(const walking::WalkOptions& options, const walking::WholeBody& body) {
  Report report;
  walking::play(walking::PatternGenerator(options, body), body,
                [&](const auto& now, const auto& before, const auto& after) {
                  const Eigen::Vector2d error = walking::zmp_error(now, before, after);
                  report.zmp_ahead.add(error.x());
                  report.zmp_aside.add(error.y());
                  report.yaw_momentum.add(after.angular.z());
                  report.yaw_moment.add(walking::yaw_moment(before, after));
                });
  return report;
}

void print(const char* arms, bool second_preview, const Report& r) {
  std::printf("  %-9s %-6s  %5.1f %5.1f  %5.1f %5.1f    %6.3f %6.3f  %6.2f %6.2f\n", arms,
              second_preview ? "two" : "one", 1e3 * r.zmp_ahead.rms(), 1e3 * r.zmp_ahead.largest,
              1e3 * r.zmp_aside.rms(), 1e3 * r.zmp_aside.largest, r.yaw_momentum.rms(),
              r.yaw_momentum.largest, r.yaw_moment.rms(), r.yaw_moment.largest);
}

void report(const char* file) {
  const auto scenario = sim::scenario::read_scenario(file).scenario;
  const walking::WholeBody body = sim::physics::nominal_body(scenario.world.robot, GAITSLAM_MODELS);
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
