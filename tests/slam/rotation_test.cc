#include "slam/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/numerical_jacobian.h"

namespace slam {
namespace {

using tests::numerical_jacobian;

constexpr double kCentral = 1e-8;  // truncation 1e-12 of curvature and rounding 1e-16/1e-6, with room

const Eigen::Vector4d kQ =
    Eigen::Vector4d(0.9, 0.1, -0.2, 0.3);  // not normalized: the derivatives hold off the sphere
const Eigen::Vector3d kA(0.4, -1.2, 2.5);

TEST(Rotation, ExponentialAgreesWithEigensAngleAxis) {
  const Eigen::Vector3d theta(0.3, -0.7, 1.1);
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(theta.norm(), theta.normalized()));
  const Eigen::Vector4d q = quaternion_exp(theta);
  EXPECT_NEAR((q - Eigen::Vector4d(expected.w(), expected.x(), expected.y(), expected.z())).norm(), 0, 1e-15);
}

TEST(Rotation, ExponentialJacobianIsItsDerivativeAtLargeSmallAndZeroAngles) {
  for (const double scale : {1.0, 1e-2, 1e-7, 0.0}) {
    const Eigen::VectorXd theta = scale * Eigen::Vector3d(0.3, -0.7, 1.1);
    const auto numeric = numerical_jacobian(
        [](const Eigen::VectorXd& t) -> Eigen::VectorXd { return quaternion_exp(t); }, theta);
    EXPECT_NEAR((quaternion_exp_jacobian(theta) - numeric).norm(), 0, kCentral) << scale;
  }
}

TEST(Rotation, LogarithmUndoesTheExponentialAndIgnoresTheQuaternionsSign) {
  for (const double scale : {1.0, 1e-3, 1e-9, 0.0}) {
    const Eigen::Vector3d theta = scale * Eigen::Vector3d(0.3, -0.7, 1.1);
    EXPECT_NEAR((quaternion_log(quaternion_exp(theta)) - theta).norm(), 0, 1e-15);
    EXPECT_NEAR((quaternion_log(-quaternion_exp(theta)) - theta).norm(), 0, 1e-15);
  }
}

TEST(Rotation, MatrixOfAUnitQuaternionIsEigens) {
  const Eigen::Vector4d q = kQ.normalized();
  EXPECT_NEAR((rotation_matrix(q) - Eigen::Quaterniond(q(0), q(1), q(2), q(3)).toRotationMatrix()).norm(), 0,
              1e-15);
}

TEST(Rotation, RotatedVectorsJacobiansAreDerivatives) {
  const auto there = numerical_jacobian(
      [](const Eigen::VectorXd& q) -> Eigen::VectorXd { return rotation_matrix(q) * kA; }, kQ);
  const auto back = numerical_jacobian(
      [](const Eigen::VectorXd& q) -> Eigen::VectorXd { return rotation_matrix(q).transpose() * kA; }, kQ);
  EXPECT_NEAR((rotated_jacobian(kQ, kA) - there).norm(), 0, kCentral);
  EXPECT_NEAR((rotated_back_jacobian(kQ, kA) - back).norm(), 0, kCentral);
}

TEST(Rotation, ProductMatricesAreTheProductsDerivatives) {
  const Eigen::Vector4d b(0.2, 0.7, -0.1, 0.6);
  const auto of_b = numerical_jacobian(
      [](const Eigen::VectorXd& x) -> Eigen::VectorXd { return quaternion_product(kQ, x); }, b);
  const auto of_a = numerical_jacobian(
      [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return quaternion_product(x, b); }, kQ);
  EXPECT_NEAR((left_matrix(kQ) - of_b).norm(), 0, kCentral);
  EXPECT_NEAR((right_matrix(b) - of_a).norm(), 0, kCentral);
}

TEST(Rotation, NormalizationJacobianIsItsDerivative) {
  const auto numeric =
      numerical_jacobian([](const Eigen::VectorXd& q) -> Eigen::VectorXd { return q.normalized(); }, kQ);
  EXPECT_NEAR((normalized_jacobian(kQ) - numeric).norm(), 0, kCentral);
}

}  // namespace
}  // namespace slam
