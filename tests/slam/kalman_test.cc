#include "slam/kalman.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "tests/slam/random_filter.h"

namespace slam {
namespace {

double smallest_eigenvalue(const Eigen::MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues().minCoeff();
}

TEST(Kalman, PredictionIsTheDenseOne) {
  Normal normal(1);
  Kalman kalman = random_filter(3, false, normal);
  const Eigen::MatrixXd P = kalman.state().P();
  const RobotVector f = random_mean(normal);
  const RobotMatrix F = random_matrix(kRobot, kRobot, normal), Q = random_covariance(normal);
  Eigen::MatrixXd F_all = Eigen::MatrixXd::Identity(P.rows(), P.rows());
  F_all.topLeftCorner<kRobot, kRobot>() = F;
  Eigen::MatrixXd expected = F_all * P * F_all.transpose();
  expected.topLeftCorner<kRobot, kRobot>() += Q;
  const Eigen::VectorXd landmarks = kalman.state().x().tail(18);
  kalman.predict(f, F, Q);
  EXPECT_LT((kalman.state().P() - expected).norm(), 1e-13 * expected.norm());
  EXPECT_EQ(kalman.state().x().head<kRobot>(), f);
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
  const Eigen::MatrixXd P = kalman.state().P(), K = dense.PHt * dense.S.inverse();
  Eigen::VectorXd x_after = kalman.state().x() + K * dense.nu;
  Eigen::MatrixXd N = Eigen::MatrixXd::Identity(P.rows(), P.rows());
  N.block<4, 4>(kOrientation, kOrientation) = normalized_jacobian(x_after.segment<4>(kOrientation));
  x_after.segment<4>(kOrientation).normalize();
  const Eigen::MatrixXd P_after = N * (P - K * dense.S * K.transpose()) * N.transpose();
  ASSERT_TRUE(update(kalman, dense.measurements));
  EXPECT_LT((kalman.state().x() - x_after).norm(), 1e-10);  // condition of S about 1e4
  EXPECT_LT((kalman.state().P() - P_after).norm(), 1e-10);
}

/// A filter whose quaternion is known and unrelated to all else, so that normalising it changes nothing and
/// the update stays linear.
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
  const Eigen::VectorXd x0 = block.state().x();
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
    const Eigen::MatrixXd before = kalman.state().P();
    ASSERT_TRUE(
        update(kalman, {random_measurement(3, kRobot, 0.1, normal), random_measurement(2, 0, 1, normal)}));
    EXPECT_GT(smallest_eigenvalue(before - kalman.state().P()), -1e-14 * before.norm());  // rounding
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
    const Eigen::MatrixXd P = kalman.state().P();
    // A quaternion's length has no uncertainty, so that P is only semi-definite: 0 but for rounding.
    EXPECT_GT(smallest_eigenvalue(P), -1e-12 * P.norm()) << sigma;
    EXPECT_NEAR(kalman.state().orientation().norm(), 1, 1e-15);
  }
}

TEST(Kalman, UncertaintyOfTheQuaternionsLengthIsGoneAfterAnUpdate) {
  Normal normal(6);
  Kalman kalman = random_filter(2, false, normal);
  ASSERT_TRUE(update(kalman, {random_measurement(2, kRobot, 0.1, normal)}));
  const Eigen::MatrixXd P = kalman.state().P();
  EXPECT_LT((P.middleCols<4>(kOrientation) * kalman.state().orientation()).norm(), 1e-14 * P.norm());
}

TEST(Kalman, RefusesAnIndefiniteInnovationCovarianceAndANanInnovationAndChangesNothing) {
  Normal normal(7);
  Kalman kalman = random_filter(2, true, normal);
  const Eigen::MatrixXd P = kalman.state().P();
  const Eigen::VectorXd x = kalman.state().x();
  Measurement indefinite = random_measurement(2, kRobot, 0.1, normal), nan = indefinite;
  indefinite.R(0, 0) = -1e9;
  nan.innovation(1) = std::nan("");
  EXPECT_FALSE(update(kalman, {indefinite}));
  EXPECT_FALSE(update(kalman, {nan}));
  EXPECT_EQ(kalman.state().x(), x);
  EXPECT_EQ(kalman.state().P(), P);
}

TEST(Kalman, ALandmarkAddedIsAsUncertainAndCorrelatedAsItsInitializationSays) {
  Normal normal(9);
  Kalman kalman = random_filter(2, false, normal);
  const Eigen::MatrixXd P = kalman.state().P();
  const Eigen::VectorXd x = kalman.state().x();
  const LandmarkInitialization b = random_landmark(normal);
  const int at = kalman.append(b), size = static_cast<int>(P.rows());
  ASSERT_EQ(at, size);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(size + 6, size);
  J.topRows(size).setIdentity();
  J.bottomLeftCorner(6, kRobot) = b.J_robot;
  Eigen::MatrixXd expected = J * P * J.transpose();
  expected.bottomRightCorner<6, 6>() += b.noise;
  EXPECT_LT((kalman.state().P() - expected).norm(), 1e-13 * expected.norm());
  EXPECT_EQ(kalman.state().x().head(size), x);
  EXPECT_EQ(kalman.state().x().tail<6>(), b.y);
}

TEST(Kalman, AKnownPointIsAsUncertainAsToldAndUncorrelated) {
  Normal normal(16);
  Kalman kalman = random_filter(1, true, normal);
  const Eigen::MatrixXd P = kalman.state().P();
  const int at = kalman.append_point({1, 2, 3}, 0.1);
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(P.rows() + 3, P.rows() + 3);
  expected.topLeftCorner(P.rows(), P.rows()) = P;
  expected.bottomRightCorner<3, 3>().diagonal().setConstant(0.1 * 0.1);
  EXPECT_EQ(at, P.rows());
  EXPECT_EQ(kalman.state().P(), expected);
  EXPECT_EQ(kalman.state().x().tail<3>(), Eigen::Vector3d(1, 2, 3));
}

TEST(Kalman, ResettingTheRobotMakesItIndependentAndLeavesTheLandmarks) {
  Normal normal(17);
  Kalman kalman = random_filter(2, true, normal);
  const Eigen::MatrixXd P = kalman.state().P();
  const RobotState robot{random_mean(normal), random_covariance(normal)};
  kalman.reset_robot(robot);
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(P.rows(), P.rows());
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

TEST(Kalman, ALandmarkErasedLeavesAllTheOthersBitForBit) {
  Normal normal(10);
  Kalman kalman = random_filter(4, true, normal);
  const Eigen::MatrixXd P = kalman.state().P();
  const Eigen::VectorXd x = kalman.state().x(), null = kalman.state().null_yaw();
  kalman.erase(kRobot + 6, 6);
  std::vector<int> kept;
  for (int i = 0; i < P.rows(); ++i)
    if (i < kRobot + 6 || i >= kRobot + 12) kept.push_back(i);
  EXPECT_EQ(kalman.state().P(), Eigen::MatrixXd(P(kept, kept)));
  EXPECT_EQ(kalman.state().x(), Eigen::VectorXd(x(kept)));
  EXPECT_EQ(kalman.state().null_yaw(), Eigen::VectorXd(null(kept)));
}

TEST(Kalman, ALandmarkReplacedKeepsItsCovarianceThroughTheJacobianAndTheOthersAsTheyWere) {
  Normal normal(11);
  Kalman kalman = random_filter(3, true, normal);
  const Eigen::MatrixXd P = kalman.state().P();
  const Eigen::VectorXd x = kalman.state().x(), null = kalman.state().null_yaw();
  const int size = static_cast<int>(P.rows()), at = kRobot + 6;
  const Eigen::VectorXd y = random_matrix(3, 1, normal);
  const Eigen::MatrixXd J = random_matrix(3, 6, normal);
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(size - 3, size);
  T.topLeftCorner(at, at).setIdentity();
  T.block(at, at, 3, 6) = J;
  T.bottomRightCorner(6, 6).setIdentity();
  kalman.replace(at, 6, y, J);
  ASSERT_EQ(kalman.state().size, size - 3);
  EXPECT_LT((kalman.state().P() - T * P * T.transpose()).norm(), 1e-13 * P.norm() * J.squaredNorm());
  EXPECT_EQ(kalman.state().x().head(at), x.head(at));
  EXPECT_EQ(Eigen::VectorXd(kalman.state().x().segment(at, 3)), y);
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
  EXPECT_EQ(Eigen::MatrixXd(m.H_robot), Eigen::MatrixXd(given.H_robot));
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

/// A filter whose plan was wrong by `delta` from the start on, after a few steps of all kinds. What is
/// measured is what a filter with the right plan predicts: the gain depends on the mean by the quaternion's
/// normalization, and that, which an extended Kalman filter leaves out of its derivatives, does not count
/// where innovations vanish.
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
    const Eigen::VectorXd error = right.state().x() - wrong.state().x();
    plan.innovation = plan.H_robot * error.head<kRobot>() + delta * plan.sensitivity.col(which);
    landmark.innovation = landmark.H_robot * error.head<kRobot>() +
                          landmark.H_landmark * error.segment<6>(kRobot) + delta * landmark.sensitivity.col(which);
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
    const Eigen::VectorXd expected = (more.state().x() - less.state().x()) / (2 * kStep);
    const Eigen::VectorXd carried = at_zero.state().storage_sensitivity.col(which).head(at_zero.state().size);
    EXPECT_GT(expected.norm(), 0.1);
    EXPECT_LT((carried - expected).norm(), 1e-6 * expected.norm());  // of the difference, cubic in the step
  }
}

/// The 2x2 covariance of a lasting error at `at`, and what a match that contains it makes of the state, as if H were dense.
TEST(Kalman, AMatchWithALastingErrorUpdatesAsItsDenseJacobianSays) {
  Normal normal(5);
  Kalman kalman({random_matrix(kRobot, 1, normal), random_covariance(normal)}, false, 3);
  kalman.append(random_landmark(normal));
  kalman.append(random_landmark(normal));
  kalman.reset_match_bias(kRobot + 2, 0.3);
  const int first = kRobot + 6, size = kalman.state().size;
  Measurement m = random_measurement(2, first, 0.1, normal);
  m.bias_at = kRobot + 2;
  m.bias_gain = 1.4;
  ASSERT_TRUE(update(kalman, {m}));  // correlates the error with robot and landmark
  kalman.predict_match_bias(kRobot + 2, 0.9, 0.01);
  m = random_measurement(2, first, 0.1, normal);
  m.bias_at = kRobot + 2;
  m.bias_gain = 1.4;
  m.innovation = random_matrix(2, 1, normal);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, size);
  H.leftCols<kRobot>() = m.H_robot;
  H.middleCols(first, 6) = m.H_landmark;
  H.middleCols<2>(kRobot + 2) = 1.4 * Eigen::Matrix2d::Identity();
  const Eigen::MatrixXd P = kalman.state().P(), S = H * P * H.transpose() + m.R;
  EXPECT_LT((innovation_covariance(kalman.state(), m) - S).norm(), 1e-9 * S.norm());
  ASSERT_TRUE(update(kalman, {m}));
  const Eigen::MatrixXd K = P * H.transpose() * S.inverse();
  const Eigen::MatrixXd after = P - K * S * K.transpose();
  const int from = kOrientation + 4;  // the quaternion is normalized besides
  EXPECT_LT((kalman.state().P() - after).bottomRightCorner(size - from, size - from).norm(), 1e-9 * P.norm());
}

TEST(Kalman, AResetErrorIsIndependentOfAllOthersAndAPredictedOneDecays) {
  Normal normal(6);
  Kalman kalman({random_matrix(kRobot, 1, normal), random_covariance(normal)}, false, 2);
  kalman.append(random_landmark(normal));
  kalman.reset_match_bias(kRobot, 0.5);
  Measurement m = random_measurement(2, kRobot + 4, 0.1, normal);
  m.bias_at = kRobot, m.bias_gain = 1, m.innovation = random_matrix(2, 1, normal);
  ASSERT_TRUE(update(kalman, {m}));
  const Eigen::MatrixXd P = kalman.state().P();
  const Eigen::VectorXd x = kalman.state().x();
  Eigen::VectorXd decay = Eigen::VectorXd::Ones(x.size());
  decay.segment<2>(kRobot).setConstant(0.8);
  Eigen::MatrixXd expected = decay.asDiagonal() * P * decay.asDiagonal();
  expected.diagonal().segment<2>(kRobot).array() += 0.2;
  kalman.predict_match_bias(kRobot, 0.8, 0.2);
  EXPECT_LT((kalman.state().P() - expected).norm(), 1e-12 * P.norm());
  EXPECT_LT((kalman.state().x() - decay.cwiseProduct(x)).norm(), 1e-12);
  kalman.reset_match_bias(kRobot, 0.7);
  EXPECT_DOUBLE_EQ(kalman.state().P().middleRows<2>(kRobot).norm(), std::sqrt(2) * 0.7);
  EXPECT_EQ(kalman.state().x().segment<2>(kRobot).norm(), 0);
}

}  // namespace
}  // namespace slam
