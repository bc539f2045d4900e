#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using namespace std::chrono_literals;

/// Ten seconds ahead at 0.1 m/s, a frame each second; the true waist is beside its path by the end by 50 mm,
/// in proportion to the time, and turned by 5 degrees. Two laps: 2 to 5 s and 5 to 8 s.
class Navigation : public RunTest {
 protected:
  Navigation() {
    run.desired.emplace();
    for (int i = 0; i <= 10; ++i) {
      const Stamp t = i * 1s;
      run.desired->waist.push_back({t, upright(0.1 * i, 0, 0.6)});
      run.plan_waist.push_back({t, upright(0.1 * i, -0.005 * i, 0.6)});
      run.truth_waist.push_back({t, upright(0.1 * i, 0.005 * i, 0.59, 0.5 * kDegree * i)});
      run.truth_camera.push_back({t, upright(0.1 * i, 0.005 * i, 0.6)});
    }
    run.desired->end = upright(1, 0, 0.6);
    run.desired->laps = {{2s, 5s}, {5s, 8s}};
  }
};

TEST_F(Navigation, ErrorsAreThoseOfTheTrueWaistFromTheCommandedPathOnTheGround) {
  double squares = 0;
  for (int i = 1; i <= 10; ++i) squares += std::pow(0.005 * i, 2);
  EXPECT_NEAR(value("navigation_rmse_m"), std::sqrt(squares / 10), 1e-12);
  EXPECT_NEAR(value("navigation_end_position_error_m"), 0.05, 1e-12);
  EXPECT_NEAR(value("navigation_end_yaw_error_deg"), 5, 1e-9);
  EXPECT_NEAR(value("navigation_first_lap_end_error_m"), 0.025, 1e-12);
  EXPECT_NEAR(value("navigation_last_lap_end_error_m"), 0.040, 1e-12);
}

TEST_F(Navigation, AWalkWithoutLapsOrThatFellInOneSaysSo) {
  run.truth_waist.resize(7);
  EXPECT_EQ(reason("navigation_last_lap_end_error_m"), "the lap was not finished");
  EXPECT_NEAR(value("navigation_first_lap_end_error_m"), 0.025, 1e-12);
  run.desired->laps.clear();
  EXPECT_EQ(reason("navigation_last_lap_end_error_m"), "the walk has no laps: no command is repeated");
  run.desired.reset();
  EXPECT_EQ(reason("navigation_rmse_m"), "no path was commanded");
}

TEST_F(Navigation, CorrectionsAreCountedAndMeasured) {
  EXPECT_EQ(reason("steps_corrected"), "the walk was not steered");
  run.steered = true;
  EXPECT_EQ(reason("steps_corrected"), "no footstep could be corrected");
  run.corrections = {{1s, 0.003, -0.004, 0}, {2s, 0, 0, -2 * kDegree}, {3s, 0, 0, 0}, {4s, 0, 0.001, 0}};
  EXPECT_EQ(value("steps_corrected"), 3);
  EXPECT_NEAR(value("correction_largest_m"), 0.005, 1e-12);
  EXPECT_NEAR(value("correction_largest_deg"), 2, 1e-9);
}

TEST_F(Navigation, TimelinessIsThatOfTheAnswers) {
  EXPECT_EQ(reason("dropped_frames"), "the filter was not run");
  run.estimate.emplace();
  EXPECT_EQ(reason("latency_p99_ms"), "answers take no simulated time: estimator.time.model is none");
  run.timeliness = {{60, 70, 80}, {60, 60, 60}, 40, 1};
  for (const auto& [name, expected] : {std::pair("dropped_frames", 1.0),
                                       {"dropped_frames_fraction", 0.25},
                                       {"latency_median_ms", 70},
                                       {"latency_p99_ms", 80},
                                       {"budget_fraction_mean", 1.5},
                                       {"budget_fraction_p99", 1.5}})
    EXPECT_NEAR(value(name), expected, 0.25) << name;
}

// The corrections take back what the robot drifts, here 20 of the 360 degrees.
TEST_F(Navigation, TheLoopOfASteeredWalkIsThatOfItsCommands) {
  run.estimate.emplace();
  for (int i = 0; i <= 10; ++i) {
    run.desired->waist[i].X.linear() = about_z(36 * kDegree * i);
    run.plan_waist[i].X.linear() = about_z(34 * kDegree * i);
    run.estimate->push_back({i * 1s, run.truth_camera[i].X});
  }
  const std::string too_little = "the executed part of the plan turns by less than 350 degrees";
  EXPECT_EQ(reason("loop_closed"), too_little);
  run.steered = true;
  EXPECT_NE(reason("loop_closed"), too_little);
}

}  // namespace
}  // namespace sim::score
