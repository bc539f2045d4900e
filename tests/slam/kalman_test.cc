#include "slam/kalman.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "tests/slam/synthetic_room.h"

namespace slam {
namespace {

using synthetic::Normal;

Eigen::MatrixXd random_matrix(int rows, int columns, Normal& normal) {
  Eigen::MatrixXd A(rows, columns);
  for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = normal();
  return A;
}

RobotVector random_mean(Normal& normal) {
  RobotVector x = random_matrix(kRobot, 1, normal);
  x.segment<4>(kOrientation).normalize();
  return x;
}

RobotMatrix random_covariance(Normal& normal) {
  const RobotMatrix A = random_matrix(kRobot, kRobot, normal), P = 0.01 * A * A.transpose();
  return (P + P.transpose()) / 2;  // symmetric to the last bit
}

Beginning random_beginning(Normal& normal) {
  const Eigen::MatrixXd A = random_matrix(6, 6, normal);
  return {random_matrix(6, 1, normal), random_matrix(6, kRobot, normal), 0.01 * A * A.transpose()};
}

/// A robot and `landmarks` landmarks of 6 parameters, all correlated.
Kalman random_filter(int landmarks, bool constrained, Normal& normal) {
  Kalman kalman(random_mean(normal), random_covariance(normal), constrained);
  for (int i = 0; i < landmarks; ++i) kalman.append(random_beginning(normal));
  return kalman;
}

Measurement random_measurement(int rows, int landmark_at, double sigma, Normal& normal) {
  Measurement m(rows);
  m.innovation = 0.1 * random_matrix(rows, 1, normal);
  m.H_robot = random_matrix(rows, kRobot, normal);
  if (landmark_at > 0) m.H_landmark = random_matrix(rows, 6, normal);
  m.landmark_at = landmark_at;
  m.R.diagonal().setConstant(sigma * sigma);
  return m;
}

Eigen::MatrixXd dense_H(const Measurement& m, int size) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(m.rows, size);
  H.leftCols<kRobot>() = m.H_robot;
  if (m.H_landmark.cols() > 0) H.middleCols(m.landmark_at, m.H_landmark.cols()) += m.H_landmark;
  return H;
}

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

TEST(Kalman, BlockUpdateIsTheTextbookOneWithTheQuaternionNormalised) {
  Normal normal(2);
  Kalman kalman = random_filter(3, false, normal);
  const Eigen::MatrixXd P = kalman.state().P();
  const Eigen::VectorXd x = kalman.state().x();
  const int size = static_cast<int>(P.rows());
  const std::vector<Measurement> measurements{random_measurement(3, 0, 0.1, normal),
                                              random_measurement(2, kRobot + 6, 0.3, normal),
                                              random_measurement(1, 0, 0.2, normal)};
  Eigen::MatrixXd H(6, size), R = Eigen::MatrixXd::Zero(6, 6);
  Eigen::VectorXd nu(6);
  for (int row = 0; const Measurement& m : measurements) {
    H.middleRows(row, m.rows) = dense_H(m, size);
    R.block(row, row, m.rows, m.rows) = m.R;
    nu.segment(row, m.rows) = m.innovation;
    row += m.rows;
  }
  const Eigen::MatrixXd S = H * P * H.transpose() + R, K = P * H.transpose() * S.inverse();
  Eigen::VectorXd x_after = x + K * nu;
  Eigen::MatrixXd N = Eigen::MatrixXd::Identity(size, size);
  N.block<4, 4>(kOrientation, kOrientation) = normalised_jacobian(x_after.segment<4>(kOrientation));
  x_after.segment<4>(kOrientation).normalize();
  const Eigen::MatrixXd P_after = N * (P - K * S * K.transpose()) * N.transpose();

  Joint joint;
  kalman.stack(measurements, joint);
  EXPECT_LT((joint.S() - S).norm(), 1e-13 * S.norm());
  ASSERT_TRUE(kalman.update(joint));
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
  Kalman kalman(x, P, false);
  for (int i = 0; i < 3; ++i) kalman.append(random_beginning(normal));
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
  Joint joint;
  block.stack(measurements, joint);
  ASSERT_TRUE(block.update(joint));
  for (Measurement m : measurements) {
    m.innovation -= dense_H(m, sequential.state().size) * (sequential.state().x() - x0);
    sequential.stack({m}, joint);
    ASSERT_TRUE(sequential.update(joint));
  }
  EXPECT_LT((block.state().x() - sequential.state().x()).norm(), 1e-10);  // condition of S about 1e4
  EXPECT_LT((block.state().P() - sequential.state().P()).norm(), 1e-10);
}

TEST(Kalman, AnUpdateNeverAddsUncertainty) {
  Normal normal(4);
  for (int trial = 0; trial < 20; ++trial) {
    Kalman kalman = linear_filter(normal);
    const Eigen::MatrixXd before = kalman.state().P();
    Joint joint;
    kalman.stack({random_measurement(3, kRobot, 0.1, normal), random_measurement(2, 0, 1, normal)}, joint);
    ASSERT_TRUE(kalman.update(joint));
    EXPECT_GT(smallest_eigenvalue(before - kalman.state().P()), -1e-14 * before.norm());  // rounding
    EXPECT_LT(kalman.state().P().trace(), before.trace());
  }
}

TEST(Kalman, CovarianceStaysPositiveThroughManyUpdatesAndPredictions) {
  for (const double sigma : {1.0, 1e-2, 1e-5}) {
    Normal normal(5);
    Kalman kalman = random_filter(6, true, normal);
    Joint joint;
    for (int i = 0; i < 1800; ++i) {
      RobotVector f = kalman.state().x().head<kRobot>();
      kalman.predict(f, RobotMatrix::Identity(), 1e-6 * RobotMatrix::Identity());
      Measurement m = random_measurement(2, kRobot + 6 * (i % 6), sigma, normal);
      m.innovation *= sigma;
      kalman.constrain(m);
      kalman.stack({m}, joint);
      ASSERT_TRUE(kalman.update(joint)) << i;
      ASSERT_TRUE(kalman.sound(kalman.state().size)) << i;
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
  Joint joint;
  kalman.stack({random_measurement(2, kRobot, 0.1, normal)}, joint);
  ASSERT_TRUE(kalman.update(joint));
  const Eigen::MatrixXd P = kalman.state().P();
  EXPECT_LT((P.middleCols<4>(kOrientation) * kalman.state().orientation()).norm(), 1e-14 * P.norm());
}

TEST(Kalman, RefusesAnInnovationCovarianceThatIsNotPositiveAndChangesNothing) {
  Normal normal(7);
  Kalman kalman = random_filter(2, true, normal);
  const Eigen::MatrixXd P = kalman.state().P();
  const Eigen::VectorXd x = kalman.state().x();
  Joint joint;
  kalman.stack({random_measurement(2, kRobot, 0.1, normal)}, joint);
  Joint indefinite = joint, nan = joint;
  indefinite.S()(0, 0) = -1;
  nan.innovation()(1) = std::nan("");
  EXPECT_FALSE(kalman.update(indefinite));
  EXPECT_FALSE(kalman.update(nan));
  EXPECT_EQ(kalman.state().x(), x);
  EXPECT_EQ(kalman.state().P(), P);
}

TEST(Kalman, NisIsTheSquaredInnovationInUnitsOfItsCovariance) {
  Normal normal(8);
  const Kalman kalman = random_filter(2, false, normal);
  const Measurement m = random_measurement(3, kRobot + 6, 0.1, normal);
  const Eigen::MatrixXd H = dense_H(m, kalman.state().size);
  const Eigen::MatrixXd S = H * kalman.state().P() * H.transpose() + Eigen::MatrixXd(m.R);
  const Eigen::VectorXd nu = m.innovation;
  EXPECT_LT((kalman.innovation_covariance(m) - S).norm(), 1e-13 * S.norm());
  EXPECT_NEAR(kalman.nis(m), nu.dot(S.inverse() * nu), 1e-10);
}

TEST(Kalman, ALandmarkAddedIsAsUncertainAndCorrelatedAsItsBeginningSays) {
  Normal normal(9);
  Kalman kalman = random_filter(2, false, normal);
  const Eigen::MatrixXd P = kalman.state().P();
  const Eigen::VectorXd x = kalman.state().x();
  const Beginning b = random_beginning(normal);
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

TEST(Kalman, ConstrainedMeasurementsSayNothingOnTheWorldsHeading) {
  Normal normal(12);
  const Kalman kalman = random_filter(3, true, normal);
  for (const int at : {0, kRobot, kRobot + 12}) {
    Measurement m = random_measurement(2, at, 0.1, normal);
    kalman.constrain(m);
    EXPECT_LT((dense_H(m, kalman.state().size) * kalman.state().null_yaw()).norm(), 1e-13);
  }
}

TEST(Kalman, ConstrainingLeavesAloneWhatHoldsAlreadyAndWhatIsSwitchedOff) {
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

TEST(Kalman, ConstrainingKeepsWhatTranslationsMean) {
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

}  // namespace
}  // namespace slam
