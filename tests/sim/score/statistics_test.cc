#include "sim/score/statistics.h"

#include <gmock/gmock.h>

#include <cmath>

namespace sim::score {
namespace {

using testing::DoubleEq, testing::ElementsAre;
using Numbers = std::vector<double>;

TEST(Statistics, TheLossOfAMetricWithAnExpectedValueIsTheSameAboveAndBelow) {
  const Direction three = Direction::away_from(3);
  EXPECT_EQ(loss(3, three), 0);
  for (const double off : {9.0, 1.0}) EXPECT_NEAR(loss(off, three), std::log(3), 1e-15);
  for (const double none : {0.0, -1.0, 5e-324}) {
    EXPECT_TRUE(std::isfinite(loss(none, three)));
    EXPECT_GT(loss(none, three), loss(1e-300, three));
  }
}

TEST(Significance, WilcoxonIsThatOfPublishedSamplesAndOfAllSignPatterns) {
  // Darwin's maize, cross- minus self-fertilised heights; statistic 24, exact p = 1352 / 2^15.
  const Numbers maize{6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75};
  EXPECT_EQ(wilcoxon_signed_rank(maize), 0.041259765625);
  EXPECT_EQ(wilcoxon_signed_rank({-1, -2, -3, -4, -5, -6, -7, -8}), 2 / 256.0);
  EXPECT_EQ(wilcoxon_signed_rank({0.1, 0.1, 0.1, 0.1, 0.1}), 2 / 32.0);  // ties do not matter to that
  for (const Numbers& none : {Numbers{}, {0, 0, 0}, {1, -1, 2, -2}}) EXPECT_EQ(wilcoxon_signed_rank(none), 1);
  // Ties and zeros, counted over all patterns of signs by another program.
  EXPECT_DOUBLE_EQ(wilcoxon_signed_rank({1, 1, -1, 2, 3, 3, -3, 0, 5}), 2 * 28 / 256.0);
  EXPECT_DOUBLE_EQ(wilcoxon_signed_rank({0.5, -0.5, -0.5, 2, 2, 2}), 2 * 7 / 64.0);
  EXPECT_DOUBLE_EQ(wilcoxon_signed_rank({1, 2, 2, 2, -9, 9, 9, 4, 4, -4}), 2 * 118 / 1024.0);
  EXPECT_DOUBLE_EQ(wilcoxon_signed_rank({-7, 1}), 1);
}

TEST(Significance, ExactAndApproximateWilcoxonMeet) {
  const auto p = [](int n) {
    Numbers values;
    for (int i = 1; i <= n; ++i) values.push_back(i % 3 == 0 ? -i : i);
    return wilcoxon_signed_rank(values);
  };
  // By hand: of 60, ranks to 1200 are positive, 915 expected with variance 60·61·121/24; of 50: 867, 637.5,
  // 10731.25. The tail of 50 ranks is nearly normal.
  EXPECT_NEAR(p(60), std::erfc(284.5 / std::sqrt(2 * 18452.5)), 1e-15);
  const double by_approximation = std::erfc(229 / std::sqrt(2 * 10731.25));
  EXPECT_NEAR(p(50) / by_approximation, 1, 0.05);
  EXPECT_NE(p(50), by_approximation);
}

TEST(Significance, HolmAdjustsInOrderOfSizeAndNeverDecreases) {
  EXPECT_THAT(holm({0.01, 0.04, 0.03, 0.005}),
              ElementsAre(DoubleEq(0.03), DoubleEq(0.06), DoubleEq(0.06), DoubleEq(0.02)));
  EXPECT_THAT(holm({0.9, 0.8}), ElementsAre(1, 1));
  EXPECT_TRUE(holm({}).empty());
}

TEST(Significance, TheMediansIntervalIsOfOrderStatistics) {
  EXPECT_FALSE(median_interval({1, 2, 3, 4, 5}));  // 2/32 > 5 %
  EXPECT_EQ(median_interval({6, 5, 4, 3, 2, 1}), std::pair(1.0, 6.0));
  // Tables of the sign test: n = 10 leaves out one on each side (97.9 %), n = 20 five (95.9 %).
  Numbers values;
  for (int i = 1; i <= 10; ++i) values.push_back(i);
  EXPECT_EQ(median_interval(values), std::pair(2.0, 9.0));
  for (int i = 11; i <= 20; ++i) values.push_back(i);
  EXPECT_EQ(median_interval(values), std::pair(6.0, 15.0));
}

}  // namespace
}  // namespace sim::score
