#include "sim/score/statistics.h"

#include <gmock/gmock.h>

#include <cmath>

#include "sim/score/consistency.h"
#include "tests/sim/score/score_fixtures.h"

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

TEST(Consistency, NeesIsAsComputedByHand) {
  Eigen::Isometry3d truth = upright(0.1, -0.2, 0.3);
  truth.rotate(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()));
  Matrix6d P = Matrix6d::Zero();
  P.diagonal() << 1, 1e-4, 1, 0.01, 0.04, 0.09;
  const auto nees = pose_nees(truth, Eigen::Isometry3d::Identity(), P);
  ASSERT_TRUE(nees);
  EXPECT_NEAR(nees->orientation, 4, 1e-12);  // 0.02² / 0.01²
  EXPECT_NEAR(nees->position, 3, 1e-12);     // 1 + 1 + 1
  for (const double none : {0.0, -1.0, std::nan("")}) {
    P(4, 4) = none;
    EXPECT_FALSE(pose_nees(truth, truth, P));
  }
}

TEST(Consistency, ChiSquareQuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.841458820694124, 1e-11);
  EXPECT_NEAR(chi_square_quantile(0.975, 30), 46.979242243671145, 1e-10);
  const Band ten = mean_band(3, 10), many = mean_band(3, 1000);
  EXPECT_NEAR(ten.low, 1.68, 0.005);
  EXPECT_NEAR(ten.high, 4.70, 0.005);
  EXPECT_GT(many.low, 2.8);
  EXPECT_LT(many.high, 3.2);
}

TEST(Consistency, AMeanNisIsAsExpectedOrSaysHowWrongThePredictedSpreadIs) {
  for (const auto& [nis, verdict] : {std::pair{0.9, "as expected"},
                                     {0.5, "as expected"},
                                     {2.0, "as expected"},
                                     {0.02, "its predicted spread is about 7 times too large"},
                                     {0.25, "its predicted spread is about 2.0 times too large"},
                                     {3.24, "its predicted spread is about 1.8 times too small"},
                                     {100.0, "its predicted spread is about 10 times too small"}})
    EXPECT_EQ(nis_verdict(nis), verdict) << nis;
}

// Bands of ten and of two runs: [1.679, 4.698], by the table, and [0.619, 7.225].
TEST(Consistency, TheFractionInTheBandCountsMomentsByTheMeanOfTheirRuns) {
  const std::vector<double> low(10, 1.6), inside(10, 1.7), high(10, 4.7);
  const auto fraction = band_fractions({low, inside, inside, high, {}, {0.6, 0.6}, {1, 13}}, 3);
  ASSERT_TRUE(fraction);
  EXPECT_DOUBLE_EQ(fraction->inside, 3.0 / 6);  // twice 1.7, and 7 of two
  EXPECT_DOUBLE_EQ(fraction->below, 2.0 / 6);   // 1.6, and 0.6 of two
  EXPECT_NEAR(fraction->mean, (1.6 + 2 * 1.7 + 4.7 + 0.6 + 7) / 6, 1e-12);
  EXPECT_FALSE(band_fractions({{}, {}}, 3));
}

}  // namespace
}  // namespace sim::score
