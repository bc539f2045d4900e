#include "sim/score/feet.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sim::score {
namespace {

using std::chrono::milliseconds;

// A walk in place of one sample per 10 ms; feet at y = ±0.1 and 10 samples to a support.
class Walk {
 public:
  Walk() {
    now_.feet[0].truth = now_.feet[0].plan = {0, 0.1, 0};
    now_.feet[1].truth = now_.feet[1].plan = {0, -0.1, 0};
  }
  FootSample& left() { return now_.feet[0]; }
  FootSample& right() { return now_.feet[1]; }

  void both(int count = 3) { stay(count, 0.5, 0.5); }
  void on_left(int count = 10) { stay(count, 1, 0); }
  void on_right(int count = 10) { stay(count, 0, 1); }
  void stay(int count, double left, double right) {
    for (int i = 0; i < count; ++i) {
      now_.t += milliseconds(10);
      now_.feet[0].load = left;
      now_.feet[1].load = right;
      now_.feet[0].planned_down = left > 0;
      now_.feet[1].planned_down = right > 0;
      samples_.push_back(now_);
    }
  }
  const std::vector<FeetSample>& samples() const { return samples_; }

 private:
  FeetSample now_;
  std::vector<FeetSample> samples_;
};

Pose2 sum_of_drift(const std::vector<FootRow>& rows) {
  Pose2 sum;
  for (const FootRow& row : rows) sum = {sum.x + row.drift.x, sum.y + row.drift.y, sum.yaw + row.drift.yaw};
  return sum;
}

std::vector<FootRow> rows_of(const std::vector<FootRow>& rows, FootPhase phase) {
  std::vector<FootRow> found;
  for (const FootRow& row : rows)
    if (row.phase == phase) found.push_back(row);
  return found;
}

struct Total {
  double moved = 0, turned = 0, creep = 0;
  Pose2 drift;
};
Total total(const std::vector<FootRow>& rows, FootPhase phase) {
  Total sum;
  for (const FootRow& row : rows_of(rows, phase)) {
    sum.moved += std::hypot(row.moved.x, row.moved.y);
    sum.turned += std::abs(row.moved.yaw);
    sum.creep += std::hypot(row.creep.x, row.creep.y);
  }
  sum.drift = sum_of_drift(rows_of(rows, phase));
  return sum;
}

TEST(Feet, APlanCarriedOutExactlyHasNoDrift) {
  Walk walk;
  walk.both();
  walk.on_left();
  walk.both();
  walk.on_right();
  walk.both();
  const auto rows = decompose_drift(walk.samples(), {1, 2, 0.3}, {1, 2, 0.3});
  EXPECT_FALSE(rows.empty());
  for (const FootRow& row : rows) {
    EXPECT_NEAR(std::hypot(row.drift.x, row.drift.y, row.drift.yaw), 0, 1e-15);
    EXPECT_EQ(std::hypot(row.moved.x, row.moved.y, row.moved.yaw), 0);
  }
}

TEST(Feet, ATurnOfTheStandingFootSwingsTheRestOfTheWayAboutIt) {
  Walk walk;
  walk.both();
  walk.on_left(5);
  walk.left().truth.yaw += 0.01;
  walk.right().truth = {-0.01 * -0.2, -0.1, 0.01};  // the swing foot goes with the body
  walk.on_left(5);
  walk.both();
  const Pose2 plan{1, 0.1, 0};
  const auto rows = decompose_drift(walk.samples(), {1, 0.11, 0.01}, plan);
  const Total support = total(rows, FootPhase::support);
  EXPECT_NEAR(support.turned, 0.01, 1e-12);
  EXPECT_NEAR(support.drift.yaw, 0.01, 1e-12);
  EXPECT_NEAR(support.drift.y, std::sin(0.01), 1e-12);  // 1 m ahead of the foot
  EXPECT_NEAR(total(rows, FootPhase::put_down).drift.y, 0, 1e-4);
}

TEST(Feet, AFootPutDownBesideItsPlaceIsALandingErrorAndNoSlip) {
  Walk walk;
  walk.both();
  walk.on_left();
  walk.right().plan = {0.2, -0.1, 0};
  walk.right().truth = {0.207, -0.098, 0.005};
  walk.both();
  walk.on_right();
  const auto rows = decompose_drift(walk.samples(), {0.2, 0, 0}, {0.2, 0, 0});
  const auto put_down = rows_of(rows, FootPhase::put_down);
  ASSERT_EQ(put_down.size(), 1u);
  EXPECT_EQ(put_down[0].foot, Foot::right);
  EXPECT_NEAR(put_down[0].moved.x, 0.007, 1e-12);
  EXPECT_NEAR(put_down[0].moved.y, 0.002, 1e-12);
  EXPECT_NEAR(put_down[0].drift.yaw, 0.005, 1e-12);
  EXPECT_EQ(total(rows, FootPhase::landing).moved, 0);
  EXPECT_EQ(total(rows, FootPhase::support).moved, 0);
}

TEST(Feet, AFootThatDragsAfterTheOtherHasLandedHasNoShareInTheDrift) {
  Walk walk;
  walk.both();
  walk.on_left();
  walk.stay(2, 0.9, 0.1);  // the right one lands
  walk.stay(2, 0.3, 0.7);  // the left one lifts off
  walk.left().truth.x += 0.004;
  walk.stay(2, 0.1, 0.9);
  walk.on_right();
  const auto rows = decompose_drift(walk.samples(), {}, {});
  EXPECT_NEAR(total(rows, FootPhase::lift_off).moved, 0.004, 1e-12);
  EXPECT_EQ(total(rows, FootPhase::lift_off).drift.x, 0);
  EXPECT_EQ(sum_of_drift(rows).x, 0);
}

TEST(Feet, AFootSlidingAsItLandsIsToldFromOneThatSlidesUnderLoad) {
  Walk walk;
  walk.both();
  walk.on_left();
  walk.stay(3, 0.9, 0.1);
  walk.right().truth.x += 0.002;
  walk.right().creep.x = 0.0005;  // in each of the samples to come
  walk.stay(1, 0.3, 0.7);
  walk.right().truth.x += 0.003;
  walk.on_right(4);
  const auto rows = decompose_drift(walk.samples(), {0.005, 0, 0}, {});
  EXPECT_NEAR(total(rows, FootPhase::landing).moved, 0.002, 1e-12);
  EXPECT_NEAR(total(rows, FootPhase::support).moved, 0.003, 1e-12);
  EXPECT_NEAR(total(rows, FootPhase::landing).creep, 0.0005, 1e-12);
  EXPECT_NEAR(total(rows, FootPhase::support).creep, 0.002, 1e-12);
  EXPECT_NEAR(total(rows, FootPhase::support).drift.x, 0.003, 1e-12);
}

TEST(Feet, AllSharesAddUpToTheDriftOfTheWaist) {
  Walk walk;
  for (int i = 0; i < 12; ++i) {
    walk.both();
    FootSample& swing = i % 2 == 0 ? walk.right() : walk.left();
    FootSample& stand = i % 2 == 0 ? walk.left() : walk.right();
    stand.truth.yaw += 0.003 * i;
    i % 2 == 0 ? walk.on_left() : walk.on_right();
    stand.truth.x -= 0.001;
    swing.plan.x += 0.15;
    swing.plan.yaw += 0.1;
    swing.truth = {swing.plan.x + 0.01 * i, swing.plan.y - 0.02, swing.plan.yaw + 0.03};
    i % 2 == 0 ? walk.on_left(2) : walk.on_right(2);
    if (i == 5) walk.both(40);  // a rest
    // After it the foot that has landed lifts again.
    if (i == 5) ++i;
  }
  walk.both();
  const Pose2 truth{1.1, 0.2, 0.9}, plan{1.0, 0.3, 0.7};
  const auto rows = decompose_drift(walk.samples(), truth, plan);
  EXPECT_NEAR(sum_of_drift(rows).x, 0.1, 1e-9);
  EXPECT_NEAR(sum_of_drift(rows).y, -0.1, 1e-9);
  EXPECT_NEAR(std::remainder(sum_of_drift(rows).yaw - 0.2, 2 * M_PI), 0, 1e-9);
}

TEST(Feet, ABounceIsNoStepAndAScuffIsNoStance) {
  Walk walk;
  walk.both();
  walk.on_left();
  walk.stay(1, 0.9, 0.1);
  walk.stay(2, 1, 0);  // 20 ms in the air
  walk.stay(1, 0.9, 0.1);
  walk.on_right();
  walk.left().planned_down = false;
  auto samples = walk.samples();
  for (int i = 0; i < 1; ++i) samples[samples.size() - 4].feet[0].load = 0.05;  // the left one scuffs
  const auto rows = decompose_drift(samples, {}, {});
  EXPECT_EQ(rows_of(rows, FootPhase::put_down).size(), 1u);
  EXPECT_EQ(rows_of(rows, FootPhase::landing).size(), 1u);
}

}  // namespace
}  // namespace sim::score
