#include <gtest/gtest.h>

#include <numeric>

#include "walking/timeline.h"

namespace walking {
namespace {

WalkOptions one_step_each() {
  WalkOptions options;
  options.commands = {Stand{3.0}, Straight{0.15, 0}, Stand{3.0}};
  return options;
}

TEST(SmoothingWeights, AreTheReferenceOnes) {
  const auto w = smoothing_weights();
  const std::array<double, 11> expected{0,        .0190983, .0690983, .1309017, .1809017, .2,
                                        .1809017, .1309017, .0690983, .0190983, 0};
  for (int i = 0; i <= 10; ++i) EXPECT_NEAR(w[i], expected[i], 5e-8);  // seven decimals
  EXPECT_NEAR(std::accumulate(w.begin(), w.end(), 0.0), 1, 1e-15);
}

TEST(ZmpReference, GoesLinearlyToTheFootInDoubleSupportAndStaysThere) {
  const Timeline timeline(one_step_each(), {}, Eigen::Vector2d::Zero());
  const ZmpReference reference(timeline);
  const double y[] = {0, 0, .25, .5, .75, 1, 1};  // of the left foot, the first to carry the robot; 4 ticks
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(reference.raw(600 - 1 + i).y(), 0.095 * y[i], 1e-15);
  EXPECT_NEAR(reference.raw(600 + 159).y(), 0.095, 1e-15);
  EXPECT_NEAR(reference.raw(600 + 160 + 2).y(), 0, 1e-15);  // half way to the right foot
  EXPECT_NEAR(reference.raw(600 + 160 + 2).x(), 0.075, 1e-15);
  EXPECT_NEAR(reference.raw(600 + 160 + 4).y(), -0.095, 1e-15);
}

TEST(ZmpReference, EndsInTheMiddleOfTheFeetAfterHalfADoubleSupport) {
  const Timeline timeline(one_step_each(), {}, Eigen::Vector2d::Zero());
  const ZmpReference reference(timeline);
  const int end = 600 + 320;
  EXPECT_NEAR(reference.raw(end - 1).y(), -0.095, 1e-15);
  EXPECT_NEAR(reference.raw(end).y(), -0.0475, 1e-15);
  EXPECT_NEAR(reference.raw(end + 1).y(), 0, 1e-15);
  EXPECT_NEAR(reference.raw(end + 1).x(), 0.15, 1e-15);
  EXPECT_EQ(reference.raw(end + 100000), reference.raw(static_cast<std::ptrdiff_t>(timeline.ticks()) - 1));
}

TEST(ZmpReference, LiesUnderTheChosenPointOfTheFoot) {
  const Timeline timeline(one_step_each(), {{0, 0}, std::numbers::pi / 2}, {0.004, 0});
  const ZmpReference reference(timeline);
  EXPECT_LT((reference.raw(0) - Eigen::Vector2d(0, 0.004)).norm(), 1e-15);
  EXPECT_LT((reference.raw(700) - Eigen::Vector2d(-0.095, 0.004)).norm(), 1e-15);
}

TEST(ZmpReference, SmoothingKeepsWhatIsConstantAndSpreadsAStepOverNineTicks) {
  const Timeline timeline(one_step_each(), {}, Eigen::Vector2d::Zero());
  const ZmpReference reference(timeline);
  EXPECT_EQ(reference.smoothed(500), reference.raw(500));
  EXPECT_NEAR(reference.smoothed(700).y(), 0.095, 1e-15);
  for (int k = 599; k < 615; ++k) EXPECT_GE(reference.smoothed(k + 1).y(), reference.smoothed(k).y());
  EXPECT_EQ(reference.smoothed(599).y(), 0);  // 601 is the first on its way; the window looks one tick ahead
  EXPECT_GT(reference.smoothed(600).y(), 0);
  EXPECT_LT(reference.smoothed(610).y(), 0.095);
  EXPECT_NEAR(reference.smoothed(611).y(), 0.095, 1e-15);
}

}  // namespace
}  // namespace walking
