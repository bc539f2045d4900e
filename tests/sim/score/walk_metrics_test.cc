#include <gtest/gtest.h>

#include <cmath>

#include "sim/score/run.h"
#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using namespace std::chrono_literals;

// A walk in place of one sample per 10 ms; feet at y = ±0.1 and 10 samples to a support.
class Walk {
 public:
  Walk() {
    left().truth = left().plan = {0, 0.1, 0};
    right().truth = right().plan = {0, -0.1, 0};
    both();
  }
  TrueFoot& left() { return now_.left; }
  TrueFoot& right() { return now_.right; }

  void both(int count = 3) { stay(count, 0.5, 0.5); }
  void on_left(int count = 10) { stay(count, 1, 0); }
  void on_right(int count = 10) { stay(count, 0, 1); }
  void stay(int count, double left_load, double right_load) {
    for (int i = 0; i < count; ++i) {
      now_.t += std::chrono::milliseconds(10);
      left().load_n = left_load, left().planned_down = left_load > 0;
      right().load_n = right_load, right().planned_down = right_load > 0;
      samples.push_back(now_);
    }
  }
  std::vector<FootRow> rows(const Eigen::Vector3d& waist_truth = Eigen::Vector3d::Zero(),
                            const Eigen::Vector3d& waist_plan = Eigen::Vector3d::Zero()) const {
    return decompose_drift(samples, 1, waist_truth, waist_plan);
  }
  std::vector<TrueFeet> samples;

 private:
  TrueFeet now_;
};

struct Total {
  int rows = 0;
  double moved = 0, turned = 0, creep = 0;
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();
};
Total total(const std::vector<FootRow>& rows, std::optional<FootPhase> phase = {}) {
  Total sum;
  for (const FootRow& row : rows) {
    if (phase && row.phase != *phase) continue;
    ++sum.rows;
    sum.moved += row.moved.head<2>().norm();
    sum.turned += std::abs(row.moved.z());
    sum.creep += row.creep.head<2>().norm();
    sum.drift += row.drift;
  }
  return sum;
}

TEST(Feet, APlanCarriedOutExactlyHasNoDrift) {
  Walk walk;
  walk.on_left();
  walk.both();
  walk.on_right();
  walk.both();
  const auto rows = walk.rows({1, 2, 0.3}, {1, 2, 0.3});
  EXPECT_FALSE(rows.empty());
  for (const FootRow& row : rows) {
    EXPECT_NEAR(row.drift.norm(), 0, 1e-15);
    EXPECT_EQ(row.moved.norm(), 0);
  }
}

TEST(Feet, ATurnOfTheStandingFootSwingsTheRestOfTheWayAboutIt) {
  Walk walk;
  walk.on_left(5);
  walk.left().truth.z() += 0.01;
  walk.right().truth = {-0.01 * -0.2, -0.1, 0.01};  // the swing foot goes with the body
  walk.on_left(5);
  walk.both();
  const auto rows = walk.rows({1, 0.11, 0.01}, {1, 0.1, 0});
  const Total support = total(rows, FootPhase::support);
  EXPECT_NEAR(support.turned, 0.01, 1e-12);
  EXPECT_NEAR(support.drift.z(), 0.01, 1e-12);
  EXPECT_NEAR(support.drift.y(), std::sin(0.01), 1e-12);  // 1 m ahead of the foot
  EXPECT_NEAR(total(rows, FootPhase::put_down).drift.y(), 0, 1e-4);
}

TEST(Feet, AFootPutDownBesideItsPlaceIsALandingErrorAndNoSlip) {
  Walk walk;
  walk.on_left();
  walk.right().plan = {0.2, -0.1, 0};
  walk.right().truth = {0.207, -0.098, 0.005};
  walk.both();
  walk.on_right();
  const auto rows = walk.rows({0.2, 0, 0}, {0.2, 0, 0});
  const Total put_down = total(rows, FootPhase::put_down);
  EXPECT_EQ(put_down.rows, 1);
  EXPECT_NEAR(put_down.moved, std::hypot(0.007, 0.002), 1e-12);
  EXPECT_NEAR(put_down.drift.z(), 0.005, 1e-12);
  EXPECT_EQ(total(rows, FootPhase::landing).moved, 0);
  EXPECT_EQ(total(rows, FootPhase::support).moved, 0);
}

TEST(Feet, AFootThatDragsAfterTheOtherHasLandedHasNoShareInTheDrift) {
  Walk walk;
  walk.on_left();
  walk.stay(2, 0.9, 0.1);  // the right one lands
  walk.stay(2, 0.3, 0.7);  // the left one lifts off
  walk.left().truth.x() += 0.004;
  walk.stay(2, 0.1, 0.9);
  walk.on_right();
  const auto rows = walk.rows();
  EXPECT_NEAR(total(rows, FootPhase::lift_off).moved, 0.004, 1e-12);
  EXPECT_EQ(total(rows, FootPhase::lift_off).drift.x(), 0);
  EXPECT_EQ(total(rows).drift.x(), 0);
}

TEST(Feet, AFootSlidingAsItLandsIsToldFromOneThatSlidesUnderLoad) {
  Walk walk;
  walk.on_left();
  walk.stay(3, 0.9, 0.1);
  walk.right().truth.x() += 0.002;
  walk.right().creep.x() = 0.0005;  // in each of the samples to come
  walk.stay(1, 0.3, 0.7);
  walk.right().truth.x() += 0.003;
  walk.on_right(4);
  const auto rows = walk.rows({0.005, 0, 0});
  const Total landing = total(rows, FootPhase::landing), support = total(rows, FootPhase::support);
  EXPECT_NEAR(landing.moved, 0.002, 1e-12);
  EXPECT_NEAR(support.moved, 0.003, 1e-12);
  EXPECT_NEAR(landing.creep, 0.0005, 1e-12);
  EXPECT_NEAR(support.creep, 0.002, 1e-12);
  EXPECT_NEAR(support.drift.x(), 0.003, 1e-12);
}

TEST(Feet, AllSharesAddUpToTheDriftOfTheWaist) {
  Walk walk;
  for (int i = 0; i < 12; ++i) {
    walk.both();
    const bool left = i % 2 == 0;
    TrueFoot &swing = left ? walk.right() : walk.left(), &stand = left ? walk.left() : walk.right();
    stand.truth.z() += 0.003 * i;
    walk.stay(10, left, !left);
    stand.truth.x() -= 0.001;
    swing.plan.x() += 0.15;
    swing.plan.z() += 0.1;
    swing.truth = {swing.plan.x() + 0.01 * i, swing.plan.y() - 0.02, swing.plan.z() + 0.03};
    walk.stay(2, left, !left);
    if (i != 5) continue;
    walk.both(40);  // a rest; after it the foot that has landed lifts again
    ++i;
  }
  walk.both();
  const Eigen::Vector3d drift = total(walk.rows({1.1, 0.2, 0.9}, {1.0, 0.3, 0.7})).drift;
  EXPECT_NEAR(drift.x(), 0.1, 1e-9);
  EXPECT_NEAR(drift.y(), -0.1, 1e-9);
  EXPECT_NEAR(std::remainder(drift.z() - 0.2, 2 * M_PI), 0, 1e-9);
}

TEST(Feet, ABounceIsNoStepAndAScuffIsNoStance) {
  Walk walk;
  walk.on_left();
  walk.stay(1, 0.9, 0.1);
  walk.stay(2, 1, 0);  // 20 ms in the air
  walk.stay(1, 0.9, 0.1);
  walk.on_right();
  walk.samples[walk.samples.size() - 4].left.load_n = 0.05;  // the left one scuffs
  EXPECT_EQ(total(walk.rows(), FootPhase::put_down).rows, 1);
  EXPECT_EQ(total(walk.rows(), FootPhase::landing).rows, 1);
}

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
    run.estimate->push_back({run.truth_camera[i], {}});
  }
  const std::string too_little = "the executed part of the plan turns by less than 350 degrees";
  EXPECT_EQ(reason("loop_closed"), too_little);
  run.steered = true;
  EXPECT_NE(reason("loop_closed"), too_little);
}

}  // namespace
}  // namespace sim::score
