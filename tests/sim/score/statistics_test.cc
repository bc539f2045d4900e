#include "sim/score/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sim::score {
namespace {

TEST(Statistics, AreAsComputedByHand) {
  const std::vector<double> values{3, 1, 4, 1, 5};
  EXPECT_EQ(mean(values), 2.8);
  EXPECT_EQ(median(values), 3);
  EXPECT_EQ(median({4, 1, 3, 2}), 2.5);
  EXPECT_DOUBLE_EQ(standard_deviation(values), std::sqrt(3.2));  // 12.8 / 4
  EXPECT_DOUBLE_EQ(root_mean_square(values), std::sqrt(10.4));
  EXPECT_EQ(standard_deviation({7}), 0);
}

TEST(Statistics, QuantilesRunFromLeastToGreatest) {
  const std::vector<double> values{40, 10, 30, 20};
  EXPECT_EQ(quantile(values, 0), 10);
  EXPECT_EQ(quantile(values, 1), 40);
  EXPECT_DOUBLE_EQ(quantile(values, 0.25), 17.5);
  EXPECT_DOUBLE_EQ(quantile(values, 0.99), 39.7);
  EXPECT_EQ(quantile({5}, 0.3), 5);
}

TEST(Statistics, SummaryTakesTheWorstThatTheMetricMeans) {
  const std::vector<double> values{0.1, -0.6, 0.3};
  EXPECT_EQ(summarize(values, Worst::largest).worst, 0.3);
  EXPECT_EQ(summarize(values, Worst::smallest).worst, -0.6);
  EXPECT_EQ(summarize(values, Worst::largest_magnitude).worst, -0.6);
  EXPECT_EQ(summarize({0.1, -0.2, 0.3}, Worst::largest_magnitude).worst, 0.3);
  EXPECT_EQ(summarize(values, Worst::largest).n, 3u);
  EXPECT_EQ(summarize(values, Worst::largest).median, 0.1);
  EXPECT_EQ(summarize({}, Worst::largest).n, 0u);
  EXPECT_FALSE(summarize({7}, Worst::largest).standard_deviation);
  EXPECT_EQ(summarize({1, 7, 12}, Direction::away_from(3)).worst, 12);
  EXPECT_EQ(summarize({0.5, 7, 12}, Direction::away_from(3)).worst, 0.5);
}

TEST(Statistics, TheLossOfAMetricWithAnExpectedValueIsTheSameAboveAndBelow) {
  const Direction three = Direction::away_from(3);
  EXPECT_EQ(loss(3, three), 0);
  EXPECT_NEAR(loss(9, three), std::log(3), 1e-15);
  EXPECT_NEAR(loss(1, three), std::log(3), 1e-15);
  for (const double none : {0.0, -1.0, 5e-324}) {
    EXPECT_TRUE(std::isfinite(loss(none, three)));
    EXPECT_GT(loss(none, three), loss(1e-300, three));
  }
}

}  // namespace
}  // namespace sim::score
