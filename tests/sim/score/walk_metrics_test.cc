#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <string>

#include "sim/score/metrics.h"
#include "sim/score/run.h"

namespace sim::score {
namespace {

using namespace std::chrono_literals;

constexpr double kDeg = std::numbers::pi / 180;

Eigen::Isometry3d waist_at(double x, double y, double yaw = 0) {
  return Eigen::Translation3d(x, y, 0.6) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
}

/// Ten seconds ahead at 0.1 m/s, a frame each second; the true waist is beside its path by the end by 50 mm,
/// in proportion to the time, and turned by 5 degrees. Two laps: 2 to 5 s and 5 to 8 s.
Run straight() {
  Run run;
  run.desired.emplace();
  for (int i = 0; i <= 10; ++i) {
    const Stamp t = i * 1s;
    run.desired->waist.push_back({t, waist_at(0.1 * i, 0)});
    run.plan_waist.push_back({t, waist_at(0.1 * i, -0.005 * i)});
    run.truth_waist.push_back({t, waist_at(0.1 * i, 0.005 * i, 0.5 * kDeg * i)});
    run.truth_camera.push_back({t, waist_at(0.1 * i, 0.005 * i)});
  }
  run.desired->end = waist_at(1, 0);
  run.desired->laps = {{2s, 5s}, {5s, 8s}};
  return run;
}

double value_of(const Run& run, const std::string& name) {
  const Metric metric = evaluate(run).at(name);
  EXPECT_TRUE(metric.value) << name << ": " << metric.reason;
  return metric.value.value_or(std::nan(""));
}

std::string reason_of(const Run& run, const std::string& name) { return evaluate(run).at(name).reason; }

TEST(Navigation, ErrorsAreThoseOfTheTrueWaistFromTheCommandedPath) {
  const auto run = straight();
  double squares = 0;
  for (int i = 1; i <= 10; ++i) squares += std::pow(0.005 * i, 2);
  EXPECT_NEAR(value_of(run, "navigation_rmse_m"), std::sqrt(squares / 10), 1e-12);
  EXPECT_NEAR(value_of(run, "navigation_end_position_error_m"), 0.05, 1e-12);
  EXPECT_NEAR(value_of(run, "navigation_end_yaw_error_deg"), 5, 1e-9);
}

TEST(Navigation, HeightDoesNotCount) {
  auto run = straight();
  const double before = value_of(run, "navigation_rmse_m");
  for (TimedPose& pose : run.truth_waist) pose.X.translation().z() -= 0.01;
  EXPECT_EQ(value_of(run, "navigation_rmse_m"), before);
}

TEST(Navigation, EachLapHasItsOwn) {
  const auto run = straight();
  EXPECT_NEAR(value_of(run, "navigation_first_lap_end_error_m"), 0.025, 1e-12);
  EXPECT_NEAR(value_of(run, "navigation_last_lap_end_error_m"), 0.040, 1e-12);
}

TEST(Navigation, AWalkWithoutLapsOrThatFellInOneSaysSo) {
  auto run = straight();
  run.truth_waist.resize(7);
  EXPECT_EQ(reason_of(run, "navigation_last_lap_end_error_m"), "the lap was not finished");
  EXPECT_NEAR(value_of(run, "navigation_first_lap_end_error_m"), 0.025, 1e-12);
  run.desired->laps.clear();
  EXPECT_EQ(reason_of(run, "navigation_last_lap_end_error_m"),
            "the walk has no laps: no command is repeated");
  run.desired.reset();
  EXPECT_EQ(reason_of(run, "navigation_rmse_m"), "no path was commanded");
}

TEST(Navigation, CorrectionsAreCountedAndMeasured) {
  auto run = straight();
  EXPECT_EQ(reason_of(run, "steps_corrected"), "the walk was not steered");
  run.steered = true;
  EXPECT_EQ(reason_of(run, "steps_corrected"), "no footstep could be corrected");
  run.corrections = {{1s, 0.003, -0.004, 0}, {2s, 0, 0, -2 * kDeg}, {3s, 0, 0, 0}, {4s, 0, 0.001, 0}};
  EXPECT_EQ(value_of(run, "steps_corrected"), 3);
  EXPECT_NEAR(value_of(run, "correction_mean_m"), 0.0015, 1e-12);
  EXPECT_NEAR(value_of(run, "correction_largest_m"), 0.005, 1e-12);
  EXPECT_NEAR(value_of(run, "correction_largest_deg"), 2, 1e-9);
}

// The corrections take back what the robot drifts, here 20 of the 360 degrees.
TEST(Navigation, TheLoopOfASteeredWalkIsThatOfItsCommands) {
  auto run = straight();
  run.estimate.emplace();
  for (int i = 0; i <= 10; ++i) {
    run.desired->waist[i].X.linear() = waist_at(0, 0, 36 * kDeg * i).linear();
    run.plan_waist[i].X.linear() = waist_at(0, 0, 34 * kDeg * i).linear();
    run.estimate->push_back({i * 1s, run.truth_camera[i].X});
  }
  const std::string too_little = "the executed part of the plan turns by less than 350 degrees";
  EXPECT_EQ(reason_of(run, "loop_closed"), too_little);
  run.steered = true;
  EXPECT_NE(reason_of(run, "loop_closed"), too_little);
}

}  // namespace
}  // namespace sim::score
