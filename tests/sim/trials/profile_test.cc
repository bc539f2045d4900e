// Profiles of functions with a known confidence interval.
#include "sim/trials/profile.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sim::trials {
namespace {

TEST(Quadratic, ThroughPointsOfOneIsThatOne) {
  Eigen::Matrix2d H;
  H << 4, 1, 1, 3;
  const Eigen::Vector2d g(0.5, -2);
  Eigen::MatrixXd points(9, 2);
  Eigen::VectorXd values(9);
  for (int k = 0; k < 9; ++k) {
    const Eigen::Vector2d x(k % 3 - 1, k / 3 - 1);
    points.row(k) = x.transpose();
    values(k) = 7 + g.dot(x) + x.dot(H * x) / 2;
  }
  const auto fitted = fit_quadratic(points, values);
  ASSERT_TRUE(fitted);
  EXPECT_NEAR(fitted->constant, 7, 1e-12);
  EXPECT_LT((fitted->gradient - g).norm(), 1e-12);
  EXPECT_LT((fitted->hessian - H).norm(), 1e-12);
}

TEST(Quadratic, IsNotDeterminedByTooFewPointsOrByPointsOnALine) {
  EXPECT_FALSE(fit_quadratic(Eigen::MatrixXd::Random(5, 2), Eigen::VectorXd::Zero(5)));
  Eigen::MatrixXd line(8, 2);
  for (int k = 0; k < 8; ++k) line.row(k) << k, 2 * k;
  EXPECT_FALSE(fit_quadratic(line, Eigen::VectorXd::Zero(8)));
}

TEST(Following, KeepsTheOthersWhereTheyAreBest) {
  Eigen::Matrix2d H;
  H << 4, 1, 1, 2;
  const Eigen::VectorXd d = following(H, 0);
  EXPECT_EQ(d(0), 1);
  EXPECT_NEAR(d(1), -0.5, 1e-15);  // −H_11⁻¹ H_10
}

// For runs with values a (x − m_i)² / 2 the interval for the mean of m is the textbook one, mean ± t s/√R.
TEST(Interval, OfRunsWithTheirOwnMinimaIsStudents) {
  const std::vector<double> minima{0.46, 0.52, 0.49, 0.55, 0.48};
  std::vector<double> parts;
  for (int k = 0; k <= 20; ++k) parts.push_back(0.05 * k);
  Eigen::MatrixXd values(5, 21);
  for (int run = 0; run < 5; ++run)
    for (int k = 0; k <= 20; ++k)
      values(run, k) =
          30 * std::pow(parts[static_cast<std::size_t>(k)] - minima[static_cast<std::size_t>(run)], 2) / 2;
  double s2 = 0;
  for (const double m : minima) s2 += (m - 0.5) * (m - 0.5) / 4;
  const double half = 2.7764451 * std::sqrt(s2 / 5);  // Student's t of 4 degrees of freedom
  const auto rise = rise_at_95(parts, values, 0.5);
  ASSERT_TRUE(rise);
  EXPECT_NEAR(*rise, 30 * half * half / 2, 1e-8);
}

TEST(Interval, OfOneRunIsNotKnown) {
  EXPECT_FALSE(rise_at_95({0, 0.5, 1}, Eigen::MatrixXd::Ones(1, 3), 0.5));
}

TEST(Interval, EndsWhereTheRisePassesTheThreshold) {
  Profile profile{"k", {1, 2, 3, 4, 5}, {}, {4, 1, 0, 1, 4}, 2.5, {}, {}};
  find_interval(profile);
  ASSERT_TRUE(profile.identifiable());
  EXPECT_NEAR(*profile.low, 1.5, 1e-12);
  EXPECT_NEAR(*profile.high, 4.5, 1e-12);
}

TEST(Interval, IsOpenOnTheSideWhereTheLikelihoodStaysFlat) {
  Profile profile{"k", {1, 2, 3, 4, 5}, {}, {0.2, 0.1, 0, 1, 4}, 2.5, {}, {}};
  find_interval(profile);
  EXPECT_FALSE(profile.low);
  EXPECT_TRUE(profile.high);
  EXPECT_FALSE(profile.identifiable());
}

}  // namespace
}  // namespace sim::trials
