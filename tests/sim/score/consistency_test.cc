#include "sim/score/consistency.h"

#include <gtest/gtest.h>

#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

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
