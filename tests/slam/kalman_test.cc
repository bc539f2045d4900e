#include "slam/kalman.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void expect_close(const MatrixXd& actual, const MatrixXd& expected, double relative = 1e-13) {
  ASSERT_EQ(actual.rows(), expected.rows());
  EXPECT_LT((actual - expected).norm(), relative * expected.norm());
}

/// True if no eigenvalue of the symmetric A is below -rounding |A|.
bool is_positive(const MatrixXd& A, double rounding) {
  const MatrixXd lifted = A + rounding * A.norm() * MatrixXd::Identity(A.rows(), A.cols());
  return lifted.llt().info() == Eigen::Success;
}

double log_determinant(const MatrixXd& S) {
  return 2 * MatrixXd(S.llt().matrixL()).diagonal().array().log().sum();
}

MatrixXd inverse(const MatrixXd& S) { return S.llt().solve(MatrixXd::Identity(S.rows(), S.cols())); }

TEST(Kalman, PredictionIsTheDenseOne) {
  Normal normal(1);
  Kalman kalman = random_filter(3, false, normal);
  const MatrixXd P = kalman.state().P();
  const RobotVector f = random_mean(normal);
  const RobotMatrix F = random_matrix(kRobot, kRobot, normal), Q = random_covariance(normal);
  MatrixXd F_all = MatrixXd::Identity(P.rows(), P.rows());
  F_all.topLeftCorner<kRobot, kRobot>() = F;
  MatrixXd expected = F_all * P * F_all.transpose();
  expected.topLeftCorner<kRobot, kRobot>() += Q;
  const VectorXd landmarks = kalman.state().x().tail(18);
  kalman.predict(f, F, Q);
  expect_close(kalman.state().P(), expected);
  EXPECT_EQ(kalman.state().robot(), f);
  EXPECT_EQ(kalman.state().x().tail(18), landmarks);
}

/// Updates with the measurements stacked.
bool update(Kalman& kalman, const std::vector<Measurement>& measurements) {
  StackedMeasurement stacked;
  stack(kalman.state(), measurements, stacked);
  return kalman.update(stacked);
}

TEST(Kalman, BlockUpdateIsTheTextbookOneWithTheQuaternionNormalized) {
  Normal normal(2);
  Kalman kalman = random_filter(3, false, normal);
  const DenseStack dense(kalman.state(), normal);
  const MatrixXd P = kalman.state().P(), K = dense.PHt * inverse(dense.S);
  VectorXd x_after = kalman.state().x() + K * dense.nu;
  MatrixXd N = MatrixXd::Identity(P.rows(), P.rows());
  N.block<4, 4>(kOrientation, kOrientation) = normalized_jacobian(x_after.segment<4>(kOrientation));
  x_after.segment<4>(kOrientation).normalize();
  const MatrixXd P_after = N * (P - K * dense.S * K.transpose()) * N.transpose();
  ASSERT_TRUE(update(kalman, dense.measurements));
  EXPECT_LT((kalman.state().x() - x_after).norm(), 1e-10);  // condition of S about 1e4
  EXPECT_LT((kalman.state().P() - P_after).norm(), 1e-10);
}

/// A filter with a known and uncorrelated quaternion: normalizing it changes nothing, and the update is
/// linear.
Kalman linear_filter(Normal& normal) {
  RobotMatrix P = random_covariance(normal);
  P.middleRows<4>(kOrientation).setZero();
  P.middleCols<4>(kOrientation).setZero();
  RobotVector x = random_mean(normal);
  x.segment<4>(kOrientation) << 1, 0, 0, 0;
  Kalman kalman({x, P}, false);
  for (int i = 0; i < 3; ++i) kalman.append(random_landmark(normal));
  return kalman;
}

TEST(Kalman, BlockUpdateEqualsSequentialUpdatesForLinearMeasurements) {
  Normal normal(3);
  Kalman block = linear_filter(normal);
  Kalman sequential = block;
  const VectorXd x0 = block.state().x();
  std::vector<Measurement> measurements;
  for (int i = 0; i < 8; ++i)
    measurements.push_back(random_measurement(2, i % 4 == 3 ? 0 : kRobot + 6 * (i % 4), 0.1, normal));
  ASSERT_TRUE(update(block, measurements));
  for (Measurement m : measurements) {
    m.innovation -= dense_H(m, sequential.state().size) * (sequential.state().x() - x0);
    ASSERT_TRUE(update(sequential, {m}));
  }
  EXPECT_LT((block.state().x() - sequential.state().x()).norm(), 1e-10);  // condition of S about 1e4
  EXPECT_LT((block.state().P() - sequential.state().P()).norm(), 1e-10);
}

TEST(Kalman, AnUpdateNeverAddsUncertainty) {
  Normal normal(4);
  for (int trial = 0; trial < 20; ++trial) {
    Kalman kalman = linear_filter(normal);
    const MatrixXd before = kalman.state().P();
    ASSERT_TRUE(
        update(kalman, {random_measurement(3, kRobot, 0.1, normal), random_measurement(2, 0, 1, normal)}));
    EXPECT_TRUE(is_positive(before - kalman.state().P(), 1e-14));
    EXPECT_LT(kalman.state().P().trace(), before.trace());
  }
}

TEST(Kalman, CovarianceStaysPositiveThroughManyUpdatesAndPredictions) {
  for (const double sigma : {1.0, 1e-2, 1e-5}) {
    Normal normal(5);
    Kalman kalman = random_filter(6, true, normal);
    for (int i = 0; i < 1800; ++i) {
      RobotVector f = kalman.state().x().head<kRobot>();
      kalman.predict(f, RobotMatrix::Identity(), 1e-6 * RobotMatrix::Identity());
      Measurement m = random_measurement(2, kRobot + 6 * (i % 6), sigma, normal);
      m.innovation *= sigma;
      kalman.constrain(m);
      ASSERT_TRUE(update(kalman, {m})) << i;
      ASSERT_TRUE(kalman.is_valid(kalman.state().size)) << i;
    }
    const MatrixXd P = kalman.state().P();
    // A quaternion's length has no uncertainty, so that P is only semi-definite: 0 but for rounding.
    EXPECT_TRUE(is_positive(P, 1e-12)) << sigma;
    EXPECT_NEAR(kalman.state().orientation().norm(), 1, 1e-15);
  }
}

TEST(Kalman, UncertaintyOfTheQuaternionsLengthIsGoneAfterAnUpdate) {
  Normal normal(6);
  Kalman kalman = random_filter(2, false, normal);
  ASSERT_TRUE(update(kalman, {random_measurement(2, kRobot, 0.1, normal)}));
  const MatrixXd P = kalman.state().P();
  EXPECT_LT((P.middleCols<4>(kOrientation) * kalman.state().orientation()).norm(), 1e-14 * P.norm());
}

TEST(Kalman, RejectsAnIndefiniteInnovationCovarianceAndANanInnovationWithoutChange) {
  Normal normal(7);
  Kalman kalman = random_filter(2, true, normal);
  const MatrixXd P = kalman.state().P();
  const VectorXd x = kalman.state().x();
  Measurement indefinite = random_measurement(2, kRobot, 0.1, normal), nan = indefinite;
  indefinite.R(0, 0) = -1e9;
  nan.innovation(1) = std::nan("");
  EXPECT_FALSE(update(kalman, {indefinite}));
  EXPECT_FALSE(update(kalman, {nan}));
  EXPECT_EQ(kalman.state().x(), x);
  EXPECT_EQ(kalman.state().P(), P);
}

TEST(Kalman, ALandmarkAddedHasTheCovarianceOfItsInitialization) {
  Normal normal(9);
  Kalman kalman = random_filter(2, false, normal);
  const MatrixXd P = kalman.state().P();
  const VectorXd x = kalman.state().x();
  const LandmarkInitialization b = random_landmark(normal);
  const int at = kalman.append(b), size = static_cast<int>(P.rows());
  ASSERT_EQ(at, size);
  MatrixXd J = MatrixXd::Zero(size + 6, size);
  J.topRows(size).setIdentity();
  J.bottomLeftCorner(6, kRobot) = b.J_robot;
  MatrixXd expected = J * P * J.transpose();
  expected.bottomRightCorner<6, 6>() += b.noise;
  expect_close(kalman.state().P(), expected);
  EXPECT_EQ(kalman.state().x().head(size), x);
  EXPECT_EQ(kalman.state().x().tail<6>(), b.y);
}

TEST(Kalman, AKnownPointHasTheGivenCovarianceAndIsUncorrelated) {
  Normal normal(16);
  Kalman kalman = random_filter(1, true, normal);
  const MatrixXd P = kalman.state().P();
  const int at = kalman.append_point({1, 2, 3}, 0.1);
  MatrixXd expected = MatrixXd::Zero(P.rows() + 3, P.rows() + 3);
  expected.topLeftCorner(P.rows(), P.rows()) = P;
  expected.bottomRightCorner<3, 3>().diagonal().setConstant(0.1 * 0.1);
  EXPECT_EQ(at, P.rows());
  EXPECT_EQ(kalman.state().P(), expected);
  EXPECT_EQ(kalman.state().x().tail<3>(), Eigen::Vector3d(1, 2, 3));
}

TEST(Kalman, ResettingTheRobotMakesItIndependentAndLeavesTheLandmarks) {
  Normal normal(17);
  Kalman kalman = random_filter(2, true, normal);
  const MatrixXd P = kalman.state().P();
  const RobotState robot{random_mean(normal), random_covariance(normal)};
  kalman.reset_robot(robot);
  MatrixXd expected = MatrixXd::Zero(P.rows(), P.rows());
  expected.topLeftCorner<kRobot, kRobot>() = robot.P;
  expected.bottomRightCorner<12, 12>() = P.bottomRightCorner<12, 12>();
  EXPECT_EQ(kalman.state().P(), expected);
  EXPECT_EQ(kalman.state().robot(), robot.x);
}

TEST(Kalman, AStateWithANanOrAnIndefiniteCovarianceIsNotValid) {
  Normal normal(18);
  Kalman kalman = random_filter(1, true, normal);
  EXPECT_TRUE(kalman.is_valid(kalman.state().size));
  kalman.inflate(kRobot, -1e6 * Eigen::Matrix3d::Ones());
  EXPECT_FALSE(kalman.is_valid(kalman.state().size));
  Kalman nan({RobotVector::Constant(std::nan("")), RobotMatrix::Identity()}, true);
  EXPECT_FALSE(nan.is_valid(kRobot));
}

TEST(Kalman, ErasingALandmarkLeavesAllTheOthersBitForBit) {
  Normal normal(10);
  Kalman kalman = random_filter(4, true, normal);
  const MatrixXd P = kalman.state().P();
  const VectorXd x = kalman.state().x(), null = kalman.state().null_yaw();
  kalman.erase(kRobot + 6, 6);
  std::vector<int> kept;
  for (int i = 0; i < P.rows(); ++i)
    if (i < kRobot + 6 || i >= kRobot + 12) kept.push_back(i);
  EXPECT_EQ(kalman.state().P(), MatrixXd(P(kept, kept)));
  EXPECT_EQ(kalman.state().x(), VectorXd(x(kept)));
  EXPECT_EQ(kalman.state().null_yaw(), VectorXd(null(kept)));
}

TEST(Kalman, ReplacingALandmarkTransformsItsCovarianceAndLeavesTheOthers) {
  Normal normal(11);
  Kalman kalman = random_filter(3, true, normal);
  const MatrixXd P = kalman.state().P();
  const VectorXd x = kalman.state().x(), null = kalman.state().null_yaw();
  const int size = static_cast<int>(P.rows()), at = kRobot + 6;
  const VectorXd y = random_matrix(3, 1, normal);
  const MatrixXd J = random_matrix(3, 6, normal);
  MatrixXd T = MatrixXd::Zero(size - 3, size);
  T.topLeftCorner(at, at).setIdentity();
  T.block(at, at, 3, 6) = J;
  T.bottomRightCorner(6, 6).setIdentity();
  kalman.replace(at, 6, y, J);
  ASSERT_EQ(kalman.state().size, size - 3);
  EXPECT_LT((kalman.state().P() - T * P * T.transpose()).norm(), 1e-13 * P.norm() * J.squaredNorm());
  EXPECT_EQ(kalman.state().x().head(at), x.head(at));
  EXPECT_EQ(VectorXd(kalman.state().x().segment(at, 3)), y);
  EXPECT_EQ(kalman.state().x().tail(6), x.tail(6));
  EXPECT_LT((kalman.state().null_yaw() - T * null).norm(), 1e-13);
}

TEST(Kalman, ConstrainedMeasurementsDoNotObserveTheWorldsHeading) {
  Normal normal(12);
  const Kalman kalman = random_filter(3, true, normal);
  for (const int at : {0, kRobot, kRobot + 12}) {
    Measurement m = random_measurement(2, at, 0.1, normal);
    kalman.constrain(m);
    EXPECT_LT((dense_H(m, kalman.state().size) * kalman.state().null_yaw()).norm(), 1e-13);
  }
}

TEST(Kalman, ConstrainingTwiceIsConstrainingOnceAndWithoutTheConstraintNothingChanges) {
  Normal normal(13);
  const Kalman free = random_filter(1, false, normal), constrained = random_filter(1, true, normal);
  Measurement m = random_measurement(2, kRobot, 0.1, normal);
  const Measurement given = m;
  free.constrain(m);
  EXPECT_EQ(MatrixXd(m.H_robot), MatrixXd(given.H_robot));
  constrained.constrain(m);
  const Measurement once = m;
  constrained.constrain(m);
  EXPECT_LT((m.H_robot - once.H_robot).norm() + (m.H_landmark - once.H_landmark).norm(), 1e-13);
  EXPECT_GT((once.H_robot - given.H_robot).norm(), 0.01);
}

TEST(Kalman, AConstrainedMeasurementOfDifferencesOfPositionsStaysOne) {
  Normal normal(14);
  const Kalman kalman = random_filter(1, true, normal);
  Measurement m = random_measurement(2, kRobot, 0.1, normal);
  m.H_landmark.leftCols(3) = -m.H_robot.leftCols(3);  // sees differences of positions only
  kalman.constrain(m);
  EXPECT_LT((m.H_landmark.leftCols(3) + m.H_robot.leftCols(3)).norm(), 1e-14);
}

TEST(Kalman, NullDirectionOfTheRobotIsTheDerivativeOfTurningItAboutTheVertical) {
  Normal normal(15);
  const RobotVector x = random_mean(normal);
  const auto turned = [&](double angle) {
    const Eigen::Vector4d q = quaternion_exp({0, 0, angle});
    RobotVector y = x;
    y.segment<3>(kPosition) = rotation_matrix(q) * x.segment<3>(kPosition);
    y.segment<3>(kVelocity) = rotation_matrix(q) * x.segment<3>(kVelocity);
    y.segment<4>(kOrientation) = quaternion_product(q, x.segment<4>(kOrientation));
    return y;
  };
  const RobotVector numeric = (turned(1e-6) - turned(-1e-6)) / 2e-6;
  EXPECT_LT((robot_null_yaw(x) - numeric).norm(), 1e-9);  // rounding 1e-16 / step 1e-6, with room
}

/// A filter with a systematic error of `delta` from the start, after a few steps of all kinds. It measures
/// the prediction of a filter without the error: then innovations vanish, and with them the dependence of the
/// gain on the mean, which the derivatives of an extended Kalman filter leave out.
Kalman with_systematic_error(int which, double delta) {
  Normal normal(11);
  Kalman wrong = random_filter(2, false, normal), right = wrong;
  for (int k = 0; k < 3; ++k) {
    const RobotMatrix F = RobotMatrix::Identity() + 0.1 * random_matrix(kRobot, kRobot, normal);
    const RobotMatrix Q = random_covariance(normal);
    for (Kalman* kalman : {&wrong, &right}) kalman->predict(F * kalman->state().robot(), F, Q);
    Measurement plan = random_measurement(3, 0, 0.1, normal),
                landmark = random_measurement(2, kRobot, 0.1, normal);
    plan.sensitivity = random_matrix(3, kSystematicErrors, normal);
    landmark.sensitivity = random_matrix(2, kSystematicErrors, normal);
    const VectorXd error = right.state().x() - wrong.state().x();
    plan.innovation = plan.H_robot * error.head<kRobot>() + delta * plan.sensitivity.col(which);
    landmark.innovation = landmark.H_robot * error.head<kRobot>() +
                          landmark.H_landmark * error.segment<6>(kRobot) +
                          delta * landmark.sensitivity.col(which);
    EXPECT_TRUE(update(wrong, {plan, landmark}));
    plan.innovation.setZero(), landmark.innovation.setZero();
    EXPECT_TRUE(update(right, {plan, landmark}));
    LandmarkInitialization added = random_landmark(normal);
    added.distortion = random_matrix(6, 1, normal);
    for (Kalman* kalman : {&wrong, &right}) {
      added.y = added.J_robot * kalman->state().robot();
      if (kalman == &wrong && which == kLensDistortion) added.y += delta * added.distortion;
      kalman->append(added);
      if (k == 1) kalman->erase(kRobot + 6, 6);
    }
  }
  return wrong;
}

TEST(Kalman, CarriesTheDerivativesOfItsMeanWithRespectToTheSystematicErrors) {
  constexpr double kStep = 1e-6;
  for (const int which : {kPlanScale, kLensDistortion}) {
    const Kalman at_zero = with_systematic_error(which, 0), more = with_systematic_error(which, kStep),
                 less = with_systematic_error(which, -kStep);
    const VectorXd expected = (more.state().x() - less.state().x()) / (2 * kStep);
    const VectorXd carried = at_zero.state().storage_sensitivity.col(which).head(at_zero.state().size);
    EXPECT_GT(expected.norm(), 0.1);
    EXPECT_LT((carried - expected).norm(), 1e-6 * expected.norm());  // of the difference, cubic in the step
  }
}

/// The 2x2 covariance of a lasting error at `at`, and what a match that contains it makes of the state, as if
/// H were dense.
TEST(Kalman, AMatchWithABiasUpdatesAsItsDenseJacobian) {
  Normal normal(5);
  Kalman kalman({random_matrix(kRobot, 1, normal), random_covariance(normal)}, false, 3);
  kalman.append(random_landmark(normal));
  kalman.append(random_landmark(normal));
  kalman.predict_match_bias(kRobot + 2, 0, 0.3);
  const int first = kRobot + 6, size = kalman.state().size;
  Measurement m = random_measurement(2, first, 0.1, normal);
  m.bias_at = kRobot + 2;
  m.bias_gain = 1.4;
  ASSERT_TRUE(update(kalman, {m}));  // correlates the bias with robot and landmark
  kalman.predict_match_bias(kRobot + 2, 0.9, 0.01);
  m = random_measurement(2, first, 0.1, normal);
  m.bias_at = kRobot + 2;
  m.bias_gain = 1.4;
  m.innovation = random_matrix(2, 1, normal);
  MatrixXd H = MatrixXd::Zero(2, size);
  H.leftCols<kRobot>() = m.H_robot;
  H.middleCols(first, 6) = m.H_landmark;
  H.middleCols<2>(kRobot + 2) = 1.4 * Eigen::Matrix2d::Identity();
  const MatrixXd P = kalman.state().P(), S = H * P * H.transpose() + m.R;
  expect_close(innovation_covariance(kalman.state(), m), S, 1e-9);
  ASSERT_TRUE(update(kalman, {m}));
  const MatrixXd K = P * H.transpose() * inverse(S);
  const MatrixXd after = P - K * S * K.transpose();
  const int from = kOrientation + 4;  // the quaternion is normalized besides
  EXPECT_LT((kalman.state().P() - after).bottomRightCorner(size - from, size - from).norm(), 1e-9 * P.norm());
}

TEST(Kalman, AMatchBiasDecaysAndWithoutDecayIsIndependentOfAllOthers) {
  Normal normal(6);
  Kalman kalman({random_matrix(kRobot, 1, normal), random_covariance(normal)}, false, 2);
  kalman.append(random_landmark(normal));
  kalman.predict_match_bias(kRobot, 0, 0.5);
  Measurement m = random_measurement(2, kRobot + 4, 0.1, normal);
  m.bias_at = kRobot, m.bias_gain = 1, m.innovation = random_matrix(2, 1, normal);
  ASSERT_TRUE(update(kalman, {m}));
  const MatrixXd P = kalman.state().P();
  const VectorXd x = kalman.state().x();
  VectorXd decay = VectorXd::Ones(x.size());
  decay.segment<2>(kRobot).setConstant(0.8);
  MatrixXd expected = decay.asDiagonal() * P * decay.asDiagonal();
  expected.diagonal().segment<2>(kRobot).array() += 0.2;
  kalman.predict_match_bias(kRobot, 0.8, 0.2);
  EXPECT_LT((kalman.state().P() - expected).norm(), 1e-12 * P.norm());
  EXPECT_LT((kalman.state().x() - decay.cwiseProduct(x)).norm(), 1e-12);
  kalman.predict_match_bias(kRobot, 0, 0.7);
  EXPECT_DOUBLE_EQ(kalman.state().P().middleRows<2>(kRobot).norm(), std::sqrt(2) * 0.7);
  EXPECT_EQ(kalman.state().x().segment<2>(kRobot).norm(), 0);
}

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
  const MatrixXd H = dense_H(m, state.size), S = H * state.P() * H.transpose() + MatrixXd(m.R);
  const VectorXd nu = m.innovation;
  expect_close(innovation_covariance(state, m), S);
  const Nis nis = normalized_innovation_squared(state, m);
  EXPECT_NEAR(nis.value, nu.dot(inverse(S) * nu), 1e-10);
  EXPECT_EQ(nis.dof, 3);
  EXPECT_NEAR(nis.log_determinant, log_determinant(S), 1e-10);
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
  expect_close(s.stacked.PHt(), s.dense.PHt);
  expect_close(s.stacked.S(), s.dense.S);
}

TEST(StackedMeasurement, ScaledNoiseIsThatOfMeasurementsOfThatStandardDeviation) {
  Stacked s(3);
  scale_noise(s.stacked, s.dense.measurements, 0.5);
  expect_close(s.stacked.S(), s.dense.S - 0.75 * s.dense.R);
}

TEST(StackedMeasurement, SelectionIsTheStackOfTheSelectedMeasurements) {
  const Stacked s(4);
  StackedMeasurement selected, expected;
  select(s.stacked, {0, 2}, selected);
  stack(s.kalman.state(), {s.dense.measurements[0], s.dense.measurements[2]}, expected);
  EXPECT_EQ(selected.first_row, expected.first_row);
  EXPECT_EQ(selected.innovation(), expected.innovation());
  expect_close(selected.PHt(), expected.PHt());
  expect_close(selected.S(), expected.S());
}

TEST(Whitening, GivesTheCholeskyFactorAndTheNis) {
  const Stacked s(5);
  Whitening whitening;
  ASSERT_TRUE(whitening.compute(s.stacked));
  const MatrixXd L = whitening.L().triangularView<Eigen::Lower>();
  expect_close(L * L.transpose(), s.dense.S);
  expect_close(L * whitening.innovation(), s.dense.nu);
  EXPECT_NEAR(whitening.nis().value, s.dense.nu.dot(inverse(s.dense.S) * s.dense.nu), 1e-10);
  EXPECT_NEAR(whitening.nis().log_determinant, log_determinant(s.dense.S), 1e-10);
}

TEST(Whitening, RejectsAnIndefiniteCovarianceAndAnInnovationThatIsNotFinite) {
  Stacked indefinite(6), nan(6);
  indefinite.stacked.S()(0, 0) = -1;
  nan.stacked.innovation()(1) = std::nan("");
  Whitening whitening;
  EXPECT_FALSE(whitening.compute(indefinite.stacked));
  EXPECT_FALSE(whitening.compute(nan.stacked));
}

}  // namespace
}  // namespace slam
