#include "slam/kalman.h"

#include <Eigen/Cholesky>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

void expect_close(const MatrixXd& actual, const MatrixXd& expected, double relative = 1e-13) {
  ASSERT_EQ(actual.rows(), expected.rows());
  EXPECT_LT((actual - expected).norm(), relative * expected.norm());
}

double log_determinant(const MatrixXd& S) {
  return 2 * MatrixXd(S.llt().matrixL()).diagonal().array().log().sum();
}

MatrixXd inverse(const MatrixXd& S) { return S.llt().solve(MatrixXd::Identity(S.rows(), S.cols())); }

/// A change of the state, and its effect on mean and covariance: x, and P ← T P Tᵀ + Q.
struct Change {
  std::string name;
  std::function<void(Kalman&)> apply;
  VectorXd x;
  MatrixXd T, Q;
  double tolerance = 1e-13;  // 0: nothing is rounded
};

TEST(Kalman, EveryChangeOfTheStateMatchesDenseMatrices) {
  Normal normal(1);
  const Kalman before = random_filter(3, false, normal);
  const VectorXd x = before.state().x();
  const MatrixXd P = before.state().P(), I = MatrixXd::Identity(P.rows(), P.rows());
  const Eigen::Index size = P.rows(), rest = size - kRobot;
  const auto block = [](Eigen::Index at, const MatrixXd& A, Eigen::Index all) {
    MatrixXd Q = MatrixXd::Zero(all, all);
    Q.block(at, at, A.rows(), A.rows()) = A;
    return Q;
  };
  const auto joined = [](const VectorXd& a, const VectorXd& b, const VectorXd& c = {}) {
    VectorXd all(a.size() + b.size() + c.size());
    all << a, b, c;
    return all;
  };
  const RobotState robot{random_mean(normal), random_covariance(normal)};
  const RobotMatrix F = random_matrix(kRobot, kRobot, normal);
  const LandmarkInitialization landmark = random_landmark(normal);
  const VectorXd point = random_matrix(3, 1, normal);
  const MatrixXd J = random_matrix(3, 6, normal);
  const int at = kRobot + 6;
  MatrixXd T_predict = I, T_append(size + 6, size), T_point(size + 3, size), T_replace(size - 3, size),
           T_erase(size - 6, size), T_reset = I, T_decay = I;
  T_predict.topLeftCorner<kRobot, kRobot>() = F;
  T_append << I, landmark.J_robot, MatrixXd::Zero(6, rest);
  T_point << I, MatrixXd::Zero(3, size);
  T_replace << I.topRows(at), J * I.middleRows(at, 6), I.bottomRows(6);
  T_erase << I.topRows(at), I.bottomRows(6);
  T_reset.topLeftCorner<kRobot, kRobot>().setZero();
  T_decay(at, at) = T_decay(at + 1, at + 1) = 0.8;
  const Eigen::Matrix2d I2 = Eigen::Matrix2d::Identity();
  const std::vector<Change> changes{
      {"predict", [&](Kalman& k) { k.predict(robot.x, F, robot.P); }, joined(robot.x, x.tail(rest)),
       T_predict, block(0, robot.P, size)},
      {"append", [&](Kalman& k) { EXPECT_EQ(k.append(landmark), size); }, joined(x, landmark.y), T_append,
       block(size, landmark.noise, size + 6)},
      {"append_point", [&](Kalman& k) { EXPECT_EQ(k.append_point(point, 0.5), size); }, joined(x, point),
       T_point, block(size, 0.25 * Eigen::Matrix3d::Identity(), size + 3), 0},
      {"replace", [&](Kalman& k) { k.replace(at, 6, point, J); }, joined(x.head(at), point, x.tail(6)),
       T_replace, MatrixXd::Zero(size - 3, size - 3)},
      {"erase", [&](Kalman& k) { k.erase(at, 6); }, joined(x.head(at), x.tail(6)), T_erase,
       MatrixXd::Zero(size - 6, size - 6), 0},
      {"reset_robot", [&](Kalman& k) { k.reset_robot(robot); }, joined(robot.x, x.tail(rest)), T_reset,
       block(0, robot.P, size), 0},
      {"decay of a bias", [&](Kalman& k) { k.predict_match_bias(at, 0.8, 0.2); }, T_decay * x, T_decay,
       block(at, 0.2 * I2, size)},
      {"a new bias", [&](Kalman& k) { k.predict_match_bias(at, 0, 0.7); }, block(at, -I2, size) * x + x,
       I + block(at, -I2, size), block(at, 0.7 * I2, size), 0}};
  for (const Change& change : changes) {
    Kalman kalman = before;
    change.apply(kalman);
    ASSERT_EQ(kalman.state().size, change.x.size()) << change.name;
    EXPECT_LE((kalman.state().x() - change.x).norm(), change.tolerance) << change.name;
    const MatrixXd expected = change.T * P * change.T.transpose() + change.Q;
    EXPECT_LE((kalman.state().P() - expected).norm(), change.tolerance * expected.norm()) << change.name;
    if (change.name == "append" || change.name == "replace" || change.name == "erase") {
      EXPECT_LT((kalman.state().null_yaw() - change.T * before.state().null_yaw()).norm(), 1e-13);
    }
  }
}

bool update(Kalman& kalman, const std::vector<Measurement>& measurements) {
  StackedMeasurement stacked;
  stack(kalman.state(), measurements, stacked);
  return kalman.update(stacked);
}

TEST(Kalman, BlockUpdateMatchesTheTextbookWithTheQuaternionNormalized) {
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

TEST(Kalman, AnUpdateReckonsWithConsideredParametersButLeavesThemAsTheyAre) {
  Normal normal(2);
  Kalman kalman = random_filter(3, false, normal);
  const DenseStack dense(kalman.state(), normal);
  const int at = kRobot + 6;  // the second of three landmarks
  kalman.consider(at, at + 6);
  EXPECT_FALSE(kalman.considers(at - 1));
  EXPECT_TRUE(kalman.considers(at));
  EXPECT_FALSE(kalman.considers(at + 6));
  const VectorXd x = kalman.state().x();
  const MatrixXd P = kalman.state().P();
  MatrixXd K = dense.PHt * inverse(dense.S);
  K.middleRows(at, 6).setZero();
  VectorXd x_after = x + K * dense.nu;
  MatrixXd N = MatrixXd::Identity(P.rows(), P.rows());
  N.block<4, 4>(kOrientation, kOrientation) = normalized_jacobian(x_after.segment<4>(kOrientation));
  x_after.segment<4>(kOrientation).normalize();
  // The covariance of any gain K, (I - KH) P (I - KH)' + KRK' (Joseph's form).
  const MatrixXd P_after =
      N * (P - K * dense.PHt.transpose() - dense.PHt * K.transpose() + K * dense.S * K.transpose()) *
      N.transpose();
  ASSERT_TRUE(update(kalman, dense.measurements));
  EXPECT_LT((kalman.state().x() - x_after).norm(), 1e-10);
  EXPECT_LT((kalman.state().P() - P_after).norm(), 1e-10);
  EXPECT_EQ(kalman.state().x().segment(at, 6), x.segment(at, 6));
  EXPECT_EQ(kalman.state().P().block(at, at, 6, 6), P.block(at, at, 6, 6));
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
    // A quaternion's length has no uncertainty, so P is only semidefinite: zero except for rounding.
    const MatrixXd P = kalman.state().P(),
                   rounding = MatrixXd::Identity(P.rows(), P.rows()) * 1e-12 * P.norm();
    EXPECT_EQ((P + rounding).llt().info(), Eigen::Success) << sigma;
    EXPECT_NEAR(kalman.state().orientation().norm(), 1, 1e-15);
  }
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

TEST(Kalman, AStateWithANanOrAnIndefiniteCovarianceIsNotValid) {
  Normal normal(18);
  Kalman kalman = random_filter(1, true, normal);
  EXPECT_TRUE(kalman.is_valid(kalman.state().size));
  kalman.inflate(kRobot, -1e6 * Eigen::Matrix3d::Ones());
  EXPECT_FALSE(kalman.is_valid(kalman.state().size));
  Kalman nan({RobotVector::Constant(std::nan("")), RobotMatrix::Identity()}, true);
  EXPECT_FALSE(nan.is_valid(kRobot));
}

TEST(Kalman, OnlyUnconstrainedMeasurementsObserveTheWorldsHeading) {
  Normal normal(12);
  const Kalman free = random_filter(3, false, normal), constrained = random_filter(3, true, normal);
  for (const int at : {0, kRobot, kRobot + 12}) {
    Measurement m = random_measurement(2, at, 0.1, normal);
    const MatrixXd given = dense_H(m, free.state().size);
    free.constrain(m);
    EXPECT_EQ(dense_H(m, free.state().size), given);
    constrained.constrain(m);
    const MatrixXd once = dense_H(m, constrained.state().size);
    EXPECT_LT((once * constrained.state().null_yaw()).norm(), 1e-13);
    constrained.constrain(m);
    EXPECT_LT((dense_H(m, constrained.state().size) - once).norm(), 1e-13);
  }
}

TEST(Kalman, AConstrainedMeasurementOfPositionDifferencesRemainsOne) {
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
  EXPECT_LT((robot_null_yaw(x) - numeric).norm(), 1e-9);  // rounding 1e-16 / step 1e-6, with a margin
}

/// A filter with a systematic error of `delta` from the start, after a few steps of all kinds. It measures
/// the prediction of a filter without the error. Then the innovations vanish, and with them the dependence of
/// the gain on the mean, which the derivatives of an extended Kalman filter neglect.
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
    // The tolerance is relative to the difference, whose error is cubic in the step.
    EXPECT_LT((carried - expected).norm(), 1e-6 * expected.norm());
  }
}

/// Three stacked measurements of a random filter, sparse and dense.
struct Stacked {
  explicit Stacked(std::uint64_t seed) : normal(seed) { stack(kalman.state(), dense.measurements, stacked); }
  Normal normal;
  Kalman kalman = random_filter(3, false, normal);
  DenseStack dense{kalman.state(), normal};
  StackedMeasurement stacked;
};

TEST(Measurement, InnovationCovarianceAndNisMatchTheDenseOnes) {
  Normal normal(8);
  const State state = random_filter(2, false, normal).state();
  Measurement m = random_measurement(2, kRobot + 6, 0.1, normal);
  m.bias_at = kRobot, m.bias_gain = 1.4;
  const MatrixXd H = dense_H(m, state.size), S = H * state.P() * H.transpose() + MatrixXd(m.R);
  const VectorXd nu = m.innovation;
  expect_close(innovation_covariance(state, m), S);
  const Nis nis = normalized_innovation_squared(state, m);
  EXPECT_NEAR(nis.value, nu.dot(inverse(S) * nu), 1e-10);
  EXPECT_EQ(nis.dof, 2);
  EXPECT_NEAR(nis.log_determinant, log_determinant(S), 1e-10);
  Measurement indefinite = m;
  indefinite.R(0, 0) = -1e9;
  EXPECT_EQ(normalized_innovation_squared(state, indefinite).value, std::numeric_limits<double>::infinity());
}

TEST(StackedMeasurement, MatchesTheDenseOneWithItsCholeskyFactorAndNisEvenWithScaledNoise) {
  Stacked s(2);
  EXPECT_EQ(s.stacked.first_row, (std::vector<int>{0, 3, 5, 6}));
  EXPECT_EQ(s.stacked.innovation(), s.dense.nu);
  expect_close(s.stacked.PHt(), s.dense.PHt);
  expect_close(s.stacked.S(), s.dense.S);
  Whitening whitening;
  ASSERT_TRUE(whitening.compute(s.stacked));
  const MatrixXd L = whitening.L().triangularView<Eigen::Lower>();
  expect_close(L * L.transpose(), s.dense.S);
  expect_close(L * whitening.innovation(), s.dense.nu);
  EXPECT_NEAR(whitening.nis().value, s.dense.nu.dot(inverse(s.dense.S) * s.dense.nu), 1e-10);
  EXPECT_NEAR(whitening.nis().log_determinant, log_determinant(s.dense.S), 1e-10);
  scale_noise(s.stacked, s.dense.measurements, 0.5);
  expect_close(s.stacked.S(), s.dense.S - 0.75 * s.dense.R);
}

TEST(StackedMeasurement, SelectionEqualsTheStackOfTheSelectedMeasurements) {
  const Stacked s(4);
  StackedMeasurement selected, expected;
  select(s.stacked, {0, 2}, selected);
  stack(s.kalman.state(), {s.dense.measurements[0], s.dense.measurements[2]}, expected);
  EXPECT_EQ(selected.first_row, expected.first_row);
  EXPECT_EQ(selected.innovation(), expected.innovation());
  expect_close(selected.PHt(), expected.PHt());
  expect_close(selected.S(), expected.S());
}

}  // namespace
}  // namespace slam
