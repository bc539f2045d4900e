#include "sim/score/consistency.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "sim/score/trajectory.h"
#include "tests/sim/score/random_trajectory.h"

namespace sim::score {
namespace {

TEST(Consistency, NeesIsAsComputedByHand) {
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity(), estimate = truth;
  truth.translation() = Eigen::Vector3d(0.1, -0.2, 0.3);
  truth.linear() = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()).toRotationMatrix();
  Matrix6d P = Matrix6d::Zero();
  P.diagonal() << 1, 1e-4, 1, 0.01, 0.04, 0.09;
  const auto nees = pose_nees(truth, estimate, P);
  ASSERT_TRUE(nees);
  EXPECT_NEAR(nees->orientation, 4, 1e-12);  // 0.02² / 0.01²
  EXPECT_NEAR(nees->position, 3, 1e-12);     // 1 + 1 + 1
}

TEST(Consistency, OrientationErrorIsInTheCamerasAxesAndPositionErrorInTheWorlds) {
  // Estimate turned by 90° about z: an error about W's x is one about C's −y.
  Eigen::Isometry3d estimate(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  Eigen::Isometry3d truth(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()) * estimate.linear());
  truth.translation().x() = 0.5;
  Matrix6d P = 1e6 * Matrix6d::Identity();
  P(1, 1) = 1e-4;  // about C's y
  P(3, 3) = 0.25;  // along W's x
  const auto nees = pose_nees(truth, estimate, P);
  ASSERT_TRUE(nees);
  EXPECT_NEAR(nees->orientation, 1, 1e-9);
  EXPECT_NEAR(nees->position, 1, 1e-9);
}

TEST(Consistency, CovarianceThatIsNoneGivesNothing) {
  const Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  Matrix6d P = Matrix6d::Identity();
  P(4, 4) = 0;
  EXPECT_FALSE(pose_nees(X, X, P));
  P(4, 4) = -1;
  EXPECT_FALSE(pose_nees(X, X, P));
  P(4, 4) = std::nan("");
  EXPECT_FALSE(pose_nees(X, X, P));
}

TEST(Consistency, ChiSquareQuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.841458820694124, 1e-11);
  EXPECT_NEAR(chi_square_quantile(0.95, 2), 5.991464547107979, 1e-11);
  EXPECT_NEAR(chi_square_quantile(0.99, 3), 11.344866730144373, 1e-11);
  EXPECT_NEAR(chi_square_quantile(0.025, 30), 16.790772265566623, 1e-10);
  EXPECT_NEAR(chi_square_quantile(0.975, 30), 46.979242243671145, 1e-10);
  for (const double x : {0.01, 0.5, 2.0, 3.9, 20.0}) {  // closed forms of the distribution
    EXPECT_NEAR(chi_square_quantile(1 - std::exp(-x / 2), 2), x, 1e-10 * x);
    EXPECT_NEAR(chi_square_quantile(std::erf(std::sqrt(x / 2)), 1), x, 1e-9 * x);
  }
}

TEST(Consistency, BandOfTenRunsOfThreeDegreesIsThePublishedOne) {
  const Band band = mean_band(3, 10);
  EXPECT_NEAR(band.low, 1.68, 0.005);
  EXPECT_NEAR(band.high, 4.70, 0.005);
  const Band narrow = mean_band(3, 1000);
  EXPECT_GT(narrow.low, 2.8);
  EXPECT_LT(narrow.high, 3.2);
}

// Bands of ten and of two runs: [1.679, 4.698], by the table, and [0.619, 7.225].
TEST(Consistency, TheFractionInTheBandCountsMomentsByTheMeanOfTheirRuns) {
  const std::vector<double> low(10, 1.6), inside(10, 1.7), high(10, 4.7);
  const auto fraction = band_fractions({low, inside, inside, high, {}, {0.6, 0.6}, {1, 13}}, 3);
  ASSERT_TRUE(fraction);
  EXPECT_DOUBLE_EQ(fraction->inside, 3.0 / 6);  // twice 1.7, and 7 of two
  EXPECT_DOUBLE_EQ(fraction->below, 2.0 / 6);   // 1.6, and 0.6 of two
  EXPECT_NEAR(fraction->mean, (1.6 + 2 * 1.7 + 4.7 + 0.6 + 7) / 6, 1e-12);
  EXPECT_FALSE(band_fractions({}, 3));
  EXPECT_FALSE(band_fractions({{}, {}}, 3));
}

TEST(Consistency, InnovationsOfTheRightSizeHaveTheExpectedMeanAndVariance) {
  std::vector<Innovation> right, twice;
  for (int i = 0; i < 400; ++i) {
    // Evenly spaced quantiles of chi² with 2 degrees of freedom, in scattered order.
    const double p = (i * 81 % 400 + 0.5) / 400, square = -2 * std::log(1 - p);
    right.push_back({square, 2});
    twice.push_back({2 * square, 2});
  }
  right.push_back({99, 0});  // a frame without a reading
  const auto good = summarize(right), loud = summarize(twice);
  ASSERT_TRUE(good && loud);
  EXPECT_NEAR(good->ratio, 1, 0.01);
  EXPECT_NEAR(good->variance_ratio, 1, 0.05);
  EXPECT_NEAR(loud->ratio, 2 * good->ratio, 1e-12);
  EXPECT_NEAR(loud->variance_ratio, 4 * good->variance_ratio, 1e-9);  // about its own mean
  EXPECT_FALSE(summarize({{1, 2}}));
  EXPECT_FALSE(summarize({}));
}

}  // namespace
}  // namespace sim::score
