#include "sim/score/feet.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sim::score {
namespace {

// A walk in place of one sample per 10 ms; feet at y = ±0.1 and 10 samples to a support.
class Walk {
 public:
  Walk() {
    left().truth = left().plan = {0, 0.1, 0};
    right().truth = right().plan = {0, -0.1, 0};
    both();
  }
  FootSample& left() { return now_.feet[0]; }
  FootSample& right() { return now_.feet[1]; }

  void both(int count = 3) { stay(count, 0.5, 0.5); }
  void on_left(int count = 10) { stay(count, 1, 0); }
  void on_right(int count = 10) { stay(count, 0, 1); }
  void stay(int count, double left_load, double right_load) {
    for (int i = 0; i < count; ++i) {
      now_.t += std::chrono::milliseconds(10);
      left().load = left_load;
      right().load = right_load;
      left().planned_down = left_load > 0;
      right().planned_down = right_load > 0;
      samples.push_back(now_);
    }
  }
  std::vector<FootRow> rows(const Pose2& waist_truth = {}, const Pose2& waist_plan = {}) const {
    return decompose_drift(samples, waist_truth, waist_plan);
  }
  std::vector<FeetSample> samples;

 private:
  FeetSample now_;
};

struct Total {
  int rows = 0;
  double moved = 0, turned = 0, creep = 0;
  Pose2 drift;
};
Total total(const std::vector<FootRow>& rows, std::optional<FootPhase> phase = {}) {
  Total sum;
  for (const FootRow& row : rows) {
    if (phase && row.phase != *phase) continue;
    ++sum.rows;
    sum.moved += std::hypot(row.moved.x, row.moved.y);
    sum.turned += std::abs(row.moved.yaw);
    sum.creep += std::hypot(row.creep.x, row.creep.y);
    sum.drift = {sum.drift.x + row.drift.x, sum.drift.y + row.drift.y, sum.drift.yaw + row.drift.yaw};
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
    EXPECT_NEAR(std::hypot(row.drift.x, row.drift.y, row.drift.yaw), 0, 1e-15);
    EXPECT_EQ(std::hypot(row.moved.x, row.moved.y, row.moved.yaw), 0);
  }
}

TEST(Feet, ATurnOfTheStandingFootSwingsTheRestOfTheWayAboutIt) {
  Walk walk;
  walk.on_left(5);
  walk.left().truth.yaw += 0.01;
  walk.right().truth = {-0.01 * -0.2, -0.1, 0.01};  // the swing foot goes with the body
  walk.on_left(5);
  walk.both();
  const auto rows = walk.rows({1, 0.11, 0.01}, {1, 0.1, 0});
  const Total support = total(rows, FootPhase::support);
  EXPECT_NEAR(support.turned, 0.01, 1e-12);
  EXPECT_NEAR(support.drift.yaw, 0.01, 1e-12);
  EXPECT_NEAR(support.drift.y, std::sin(0.01), 1e-12);  // 1 m ahead of the foot
  EXPECT_NEAR(total(rows, FootPhase::put_down).drift.y, 0, 1e-4);
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
  EXPECT_NEAR(put_down.drift.yaw, 0.005, 1e-12);
  EXPECT_EQ(total(rows, FootPhase::landing).moved, 0);
  EXPECT_EQ(total(rows, FootPhase::support).moved, 0);
}

TEST(Feet, AFootThatDragsAfterTheOtherHasLandedHasNoShareInTheDrift) {
  Walk walk;
  walk.on_left();
  walk.stay(2, 0.9, 0.1);  // the right one lands
  walk.stay(2, 0.3, 0.7);  // the left one lifts off
  walk.left().truth.x += 0.004;
  walk.stay(2, 0.1, 0.9);
  walk.on_right();
  const auto rows = walk.rows();
  EXPECT_NEAR(total(rows, FootPhase::lift_off).moved, 0.004, 1e-12);
  EXPECT_EQ(total(rows, FootPhase::lift_off).drift.x, 0);
  EXPECT_EQ(total(rows).drift.x, 0);
}

TEST(Feet, AFootSlidingAsItLandsIsToldFromOneThatSlidesUnderLoad) {
  Walk walk;
  walk.on_left();
  walk.stay(3, 0.9, 0.1);
  walk.right().truth.x += 0.002;
  walk.right().creep.x = 0.0005;  // in each of the samples to come
  walk.stay(1, 0.3, 0.7);
  walk.right().truth.x += 0.003;
  walk.on_right(4);
  const auto rows = walk.rows({0.005, 0, 0});
  const Total landing = total(rows, FootPhase::landing), support = total(rows, FootPhase::support);
  EXPECT_NEAR(landing.moved, 0.002, 1e-12);
  EXPECT_NEAR(support.moved, 0.003, 1e-12);
  EXPECT_NEAR(landing.creep, 0.0005, 1e-12);
  EXPECT_NEAR(support.creep, 0.002, 1e-12);
  EXPECT_NEAR(support.drift.x, 0.003, 1e-12);
}

TEST(Feet, AllSharesAddUpToTheDriftOfTheWaist) {
  Walk walk;
  for (int i = 0; i < 12; ++i) {
    walk.both();
    const bool left = i % 2 == 0;
    FootSample &swing = left ? walk.right() : walk.left(), &stand = left ? walk.left() : walk.right();
    stand.truth.yaw += 0.003 * i;
    walk.stay(10, left, !left);
    stand.truth.x -= 0.001;
    swing.plan.x += 0.15;
    swing.plan.yaw += 0.1;
    swing.truth = {swing.plan.x + 0.01 * i, swing.plan.y - 0.02, swing.plan.yaw + 0.03};
    walk.stay(2, left, !left);
    if (i != 5) continue;
    walk.both(40);  // a rest; after it the foot that has landed lifts again
    ++i;
  }
  walk.both();
  const Pose2 drift = total(walk.rows({1.1, 0.2, 0.9}, {1.0, 0.3, 0.7})).drift;
  EXPECT_NEAR(drift.x, 0.1, 1e-9);
  EXPECT_NEAR(drift.y, -0.1, 1e-9);
  EXPECT_NEAR(std::remainder(drift.yaw - 0.2, 2 * M_PI), 0, 1e-9);
}

TEST(Feet, ABounceIsNoStepAndAScuffIsNoStance) {
  Walk walk;
  walk.on_left();
  walk.stay(1, 0.9, 0.1);
  walk.stay(2, 1, 0);  // 20 ms in the air
  walk.stay(1, 0.9, 0.1);
  walk.on_right();
  walk.samples[walk.samples.size() - 4].feet[0].load = 0.05;  // the left one scuffs
  EXPECT_EQ(total(walk.rows(), FootPhase::put_down).rows, 1);
  EXPECT_EQ(total(walk.rows(), FootPhase::landing).rows, 1);
}

}  // namespace
}  // namespace sim::score
