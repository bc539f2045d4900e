#include "sim/score/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numeric>

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

TEST(Significance, WilcoxonOfDarwinsMaizeIsThePublishedOne) {
  // Cross- minus self-fertilised heights; statistic 24, exact p = 1352 / 2^15.
  const std::vector<double> maize{6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75};
  EXPECT_EQ(wilcoxon_signed_rank(maize), 0.041259765625);
}

TEST(Significance, WilcoxonOfFewDifferencesAllOfOneSignIsTheLeastThereIs) {
  EXPECT_EQ(wilcoxon_signed_rank({1, 2, 3, 4, 5}), 2 / 32.0);
  EXPECT_EQ(wilcoxon_signed_rank({-1, -2, -3, -4, -5, -6, -7, -8}), 2 / 256.0);
  EXPECT_EQ(wilcoxon_signed_rank({0.1, 0.1, 0.1, 0.1, 0.1}), 2 / 32.0);  // ties do not matter to that
}

TEST(Significance, WilcoxonOfNoDifferenceIsOne) {
  EXPECT_EQ(wilcoxon_signed_rank({}), 1);
  EXPECT_EQ(wilcoxon_signed_rank({0, 0, 0}), 1);
  EXPECT_EQ(wilcoxon_signed_rank({1, -1, 2, -2}), 1);
}

// By going through all sign patterns, for samples with ties and zeros.
double by_enumeration(std::vector<double> differences) {
  std::erase(differences, 0.0);
  const std::size_t n = differences.size();
  std::vector<double> ranks;
  for (const double a : differences) {
    double rank = 0.5;
    for (const double b : differences)
      rank += std::abs(b) < std::abs(a) ? 1 : std::abs(b) == std::abs(a) ? 0.5 : 0;
    ranks.push_back(rank);
  }
  const auto sum = [&](auto positive) {
    double s = 0;
    for (std::size_t i = 0; i < n; ++i) s += positive(i) ? ranks[i] : 0;
    return s;
  };
  const double seen = sum([&](std::size_t i) { return differences[i] > 0; });
  double below = 0, above = 0;
  for (std::size_t pattern = 0; pattern < (std::size_t{1} << n); ++pattern) {
    const double s = sum([&](std::size_t i) { return pattern >> i & 1; });
    below += s <= seen, above += s >= seen;
  }
  return std::min(1.0, 2 * std::min(below, above) / std::ldexp(1, static_cast<int>(n)));
}

TEST(Significance, WilcoxonWithTiesAndZerosIsThatOfAllSignPatterns) {
  for (const std::vector<double>& sample : {std::vector<double>{1, 1, -1, 2, 3, 3, -3, 0, 5},
                                            {0.5, -0.5, -0.5, 2, 2, 2},
                                            {-7, 1},
                                            {3},
                                            {1, 2, 2, 2, -9, 9, 9, 4, 4, -4}})
    EXPECT_DOUBLE_EQ(wilcoxon_signed_rank(sample), by_enumeration(sample));
}

TEST(Significance, ExactAndApproximateWilcoxonMeet) {
  const auto sample = [](int n) {
    std::vector<double> values;
    for (int i = 1; i <= n; ++i) values.push_back(i % 3 == 0 ? -i : i);
    return values;
  };
  // By hand: of 60, ranks to 1200 are positive, 915 expected with variance 60·61·121/24; of 50: 867, 637.5,
  // 10731.25.
  EXPECT_NEAR(wilcoxon_signed_rank(sample(60)), std::erfc(284.5 / std::sqrt(2 * 18452.5)), 1e-15);
  const double by_approximation = std::erfc(229 / std::sqrt(2 * 10731.25));
  EXPECT_NEAR(wilcoxon_signed_rank(sample(50)) / by_approximation, 1,
              0.05);  // the tail of 50 ranks is nearly normal
  EXPECT_NE(wilcoxon_signed_rank(sample(50)), by_approximation);
}

TEST(Significance, HolmAdjustsInOrderOfSizeAndNeverDecreases) {
  EXPECT_THAT(holm({0.01, 0.04, 0.03, 0.005}),
              testing::ElementsAre(testing::DoubleEq(0.03), testing::DoubleEq(0.06), testing::DoubleEq(0.06),
                                   testing::DoubleEq(0.02)));
  EXPECT_THAT(holm({0.9, 0.8}), testing::ElementsAre(1, 1));
  EXPECT_TRUE(holm({}).empty());
}

// By dealing the values out in all ways.
double rank_sum_by_enumeration(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> all = a, ranks;
  all.insert(all.end(), b.begin(), b.end());
  for (const double x : all) {
    double rank = 0.5;
    for (const double y : all) rank += y < x ? 1 : y == x ? 0.5 : 0;
    ranks.push_back(rank);
  }
  const double seen =
      std::accumulate(ranks.begin(), ranks.begin() + static_cast<std::ptrdiff_t>(a.size()), 0.0);
  double below = 0, above = 0, deals = 0;
  for (std::size_t deal = 0; deal < (std::size_t{1} << all.size()); ++deal) {
    if (static_cast<std::size_t>(std::popcount(deal)) != a.size()) continue;
    double sum = 0;
    for (std::size_t i = 0; i < all.size(); ++i) sum += deal >> i & 1 ? ranks[i] : 0;
    ++deals, below += sum <= seen, above += sum >= seen;
  }
  return std::min(1.0, 2 * std::min(below, above) / deals);
}

TEST(Significance, RankSumIsThatOfAllWaysToDealTheRanks) {
  const std::vector<std::pair<std::vector<double>, std::vector<double>>> samples{
      {{1, 2, 3, 4, 5}, {6, 7, 8, 9, 10}},
      {{1, 1, 2, 7}, {1, 2, 2, 9, 9, 3}},
      {{5}, {1, 2, 3}},
      {{2, 2}, {2, 2, 2}}};
  for (const auto& [a, b] : samples) {
    EXPECT_NEAR(rank_sum(a, b), rank_sum_by_enumeration(a, b), 1e-14);
    EXPECT_NEAR(rank_sum(a, b), rank_sum(b, a), 1e-14);
  }
  EXPECT_NEAR(rank_sum({1, 2, 3, 4, 5}, {6, 7, 8, 9, 10}), 2 / 252.0, 1e-15);  // two of the C(10,5) deals
}

TEST(Significance, RankSumOfManyIsNearTheNormalApproximation) {
  std::vector<double> a, b;
  for (int i = 0; i < 50; ++i) a.push_back(i), b.push_back(i + 5.5);
  const double exact = rank_sum(a, b);  // 100 values
  b.push_back(27.2);
  EXPECT_NEAR(rank_sum(a, b), exact, 0.15 * exact);  // one value more changes p by about 1/√n
  EXPECT_EQ(rank_sum({}, {1}), 1);
}

TEST(Significance, TheMediansIntervalIsOfOrderStatistics) {
  EXPECT_FALSE(median_interval({1, 2, 3, 4, 5}));  // 2/32 > 5 %
  EXPECT_EQ(median_interval({6, 5, 4, 3, 2, 1}), std::pair(1.0, 6.0));
  // Tables of the sign test: n = 10 leaves out one on each side (97.9 %), n = 20 five (95.9 %).
  std::vector<double> values;
  for (int i = 1; i <= 10; ++i) values.push_back(i);
  EXPECT_EQ(median_interval(values), std::pair(2.0, 9.0));
  for (int i = 11; i <= 20; ++i) values.push_back(i);
  EXPECT_EQ(median_interval(values), std::pair(6.0, 15.0));
}

}  // namespace
}  // namespace sim::score
