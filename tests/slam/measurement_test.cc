#include "slam/measurement.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "tests/slam/random_filter.h"

namespace slam {
namespace {

/// Three stacked measurements of a random filter, sparse and dense.
struct Stacked {
  explicit Stacked(std::uint64_t seed) : normal(seed) { stack(kalman.state(), dense.measurements, stacked); }
  Normal normal;
  Kalman kalman = random_filter(3, false, normal);
  DenseStack dense{kalman.state(), normal};
  StackedMeasurement stacked;
};

TEST(Measurement, InnovationCovarianceAndNisAreTheDenseOnes) {
  Normal normal(8);
  const State state = random_filter(2, false, normal).state();
  const Measurement m = random_measurement(3, kRobot + 6, 0.1, normal);
  const Eigen::MatrixXd H = dense_H(m, state.size), S = H * state.P() * H.transpose() + Eigen::MatrixXd(m.R);
  const Eigen::VectorXd nu = m.innovation;
  EXPECT_LT((innovation_covariance(state, m) - S).norm(), 1e-13 * S.norm());
  const Nis nis = normalized_innovation_squared(state, m);
  EXPECT_NEAR(nis.value, nu.dot(S.inverse() * nu), 1e-10);
  EXPECT_EQ(nis.dof, 3);
  EXPECT_NEAR(nis.log_determinant, std::log(S.determinant()), 1e-10);
}

TEST(Measurement, TheNisIsInfiniteWhereTheInnovationCovarianceIsNotPositiveDefinite) {
  Normal normal(9);
  Measurement m = random_measurement(2, 0, 0.1, normal);
  m.R(0, 0) = -1e9;
  EXPECT_EQ(normalized_innovation_squared(random_filter(0, false, normal).state(), m).value,
            std::numeric_limits<double>::infinity());
}

TEST(StackedMeasurement, IsTheDenseOne) {
  const Stacked s(2);
  EXPECT_EQ(s.stacked.first_row, (std::vector<int>{0, 3, 5, 6}));
  EXPECT_EQ(s.stacked.innovation(), s.dense.nu);
  EXPECT_LT((s.stacked.PHt() - s.dense.PHt).norm(), 1e-13 * s.dense.PHt.norm());
  EXPECT_LT((s.stacked.S() - s.dense.S).norm(), 1e-13 * s.dense.S.norm());
}

TEST(StackedMeasurement, ScaledNoiseIsThatOfMeasurementsOfThatStandardDeviation) {
  Stacked s(3);
  scale_noise(s.stacked, s.dense.measurements, 0.5);
  const Eigen::MatrixXd S = s.dense.S - 0.75 * s.dense.R;
  EXPECT_LT((s.stacked.S() - S).norm(), 1e-13 * S.norm());
}

TEST(StackedMeasurement, SelectionIsTheStackOfTheSelectedMeasurements) {
  const Stacked s(4);
  StackedMeasurement selected, expected;
  select(s.stacked, {0, 2}, selected);
  stack(s.kalman.state(), {s.dense.measurements[0], s.dense.measurements[2]}, expected);
  EXPECT_EQ(selected.first_row, expected.first_row);
  EXPECT_EQ(selected.innovation(), expected.innovation());
  EXPECT_LT((selected.PHt() - expected.PHt()).norm(), 1e-13 * expected.PHt().norm());
  EXPECT_LT((selected.S() - expected.S()).norm(), 1e-13 * expected.S().norm());
}

TEST(Whitening, GivesTheCholeskyFactorAndTheNis) {
  const Stacked s(5);
  Whitening whitening;
  ASSERT_TRUE(whitening.compute(s.stacked));
  const Eigen::MatrixXd L = whitening.L().triangularView<Eigen::Lower>();
  EXPECT_LT((L * L.transpose() - s.dense.S).norm(), 1e-13 * s.dense.S.norm());
  EXPECT_LT((L * whitening.innovation() - s.dense.nu).norm(), 1e-13);
  EXPECT_NEAR(whitening.nis().value, s.dense.nu.dot(s.dense.S.inverse() * s.dense.nu), 1e-10);
  EXPECT_NEAR(whitening.nis().log_determinant, std::log(s.dense.S.determinant()), 1e-10);
}

TEST(Whitening, RefusesAnIndefiniteCovarianceAndAnInnovationThatIsNotFinite) {
  Stacked indefinite(6), nan(6);
  indefinite.stacked.S()(0, 0) = -1;
  nan.stacked.innovation()(1) = std::nan("");
  Whitening whitening;
  EXPECT_FALSE(whitening.compute(indefinite.stacked));
  EXPECT_FALSE(whitening.compute(nan.stacked));
}

}  // namespace
}  // namespace slam
