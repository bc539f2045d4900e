#include "slam/vision/landmark.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/numerical_jacobian.h"

namespace slam {
namespace {

using tests::numerical_jacobian;

constexpr double kCentral = 1e-7;  // rounding 1e-16 / step 1e-6 of values up to 10, with room

RobotVector generic_state() {
  RobotVector x = RobotVector::Zero();
  x.segment<3>(kPosition) << 0.4, -0.3, 1.4;
  x.segment<4>(kOrientation) = Eigen::Vector4d(0.5, -0.4, 0.6, -0.45).normalized();
  return x;
}

Vector6d parameters() {
  Vector6d y;
  y << 0.4, -0.3, 1.4, 0.7, -0.2, 0.25;
  return y;
}

TEST(InverseDepth, BearingIsOfUnitLengthAndItsJacobianIsItsDerivative) {
  for (const Eigen::Vector2d& angles : {Eigen::Vector2d(0.7, -0.2), {-2.9, 1.1}, {0, 0}}) {
    const auto numeric = numerical_jacobian(
        [](const Eigen::VectorXd& a) -> Eigen::VectorXd { return bearing(a(0), a(1)); }, angles);
    EXPECT_NEAR(bearing(angles(0), angles(1)).norm(), 1, 1e-15);
    EXPECT_LT((bearing_jacobian(angles(0), angles(1)) - numeric).norm(), kCentral);
  }
}

TEST(InverseDepth, IsInitializedOnTheRayAtTheDepthOfTheOptions) {
  const Camera camera{CameraIntrinsics{}};
  const auto ray = camera.unproject({50, 200});
  Options::Depth options;
  options.inverse_1_m = 0.2;
  const RobotVector x = generic_state();
  const LandmarkInitialization b = initialize_inverse_depth(x, *ray, 1, Eigen::Vector2d::Zero(), options);
  const Eigen::Vector3d along = rotation_matrix(x.segment<4>(kOrientation)) * ray->h.normalized();
  EXPECT_LT((inverse_depth_position(b.y) - x.head<3>() - 5 * along).norm(), 1e-13);
}

TEST(InverseDepth, JacobianOfTheInitializationIsItsDerivative) {
  const Camera camera{CameraIntrinsics{}};
  const auto ray = camera.unproject({50, 200});
  const auto initialized = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return initialize_inverse_depth(x, *ray, 1, Eigen::Vector2d::Zero(), {}).y;
  };
  const RobotVector x = generic_state();
  EXPECT_LT((initialize_inverse_depth(x, *ray, 1, Eigen::Vector2d::Zero(), {}).J_robot - numerical_jacobian(initialized, x)).norm(),
            kCentral);
}

TEST(InverseDepth, ItsDerivativeWithRespectToTheDistortionIsThatOfALensToldWrong) {
  const Eigen::Vector2d pixel(50, 200);
  const auto initialized = [&](const Eigen::VectorXd& delta) -> Eigen::VectorXd {
    CameraIntrinsics told;
    const double k1 = std::get<OneParameterRadial>(told.lens).k1_px2;
    told.lens = OneParameterRadial{k1 * (1 + delta(0))};
    return initialize_inverse_depth(generic_state(), *Camera(told).unproject(pixel), 1, Eigen::Vector2d::Zero(), {}).y;
  };
  const Camera camera{CameraIntrinsics{}};
  const auto ray = camera.unproject(pixel);
  const LandmarkInitialization b =
      initialize_inverse_depth(generic_state(), *ray, 1, camera.displacement(ray->h, pixel), {});
  const Eigen::VectorXd numeric = numerical_jacobian(initialized, Eigen::VectorXd::Zero(1), 1e-4);
  // the lens's displacement is not linear in its parameter: 30 % at this pixel, and the sign and the axis are what matters
  EXPECT_GT(b.distortion.dot(numeric) / (b.distortion.norm() * numeric.norm()), 0.999);
  EXPECT_NEAR(b.distortion.norm() / numeric.norm(), 1, 0.35);
}

TEST(InverseDepth, NoiseOfTheInitializationIsThatOfPixelAndDepth) {
  const Camera camera{CameraIntrinsics{}};
  const Eigen::Vector2d pixel(50, 200);
  Options::Depth options;
  options.sigma_inverse_1_m = 0.4;
  const auto initialized = [&](const Eigen::VectorXd& p) -> Eigen::VectorXd {
    return initialize_inverse_depth(generic_state(), *camera.unproject(p), 1, Eigen::Vector2d::Zero(), options).y;
  };
  const Eigen::MatrixXd J = numerical_jacobian(initialized, pixel, 1e-4);
  Eigen::MatrixXd expected = 1.5 * 1.5 * J * J.transpose();
  expected(5, 5) += 0.16;
  const LandmarkInitialization b =
      initialize_inverse_depth(generic_state(), *camera.unproject(pixel), 1.5, Eigen::Vector2d::Zero(), options);
  EXPECT_LT((b.noise - expected).norm(), 1e-11);  // slopes 5e-3 rad/px
}

TEST(InverseDepth, PositionsJacobianIsItsDerivative) {
  const auto numeric = numerical_jacobian(
      [](const Eigen::VectorXd& y) -> Eigen::VectorXd { return inverse_depth_position(y); }, parameters());
  EXPECT_LT((inverse_depth_position_jacobian(parameters()) - numeric).norm(), kCentral);
}

TEST(InverseDepth, APointAtInfinityOrBehindItHasAFinitePositionAndIsNeverLinear) {
  for (const double rho : {0.0, -0.1}) {
    Vector6d y = parameters();
    y(5) = rho;
    EXPECT_TRUE(inverse_depth_position(y).allFinite());
    EXPECT_TRUE(inverse_depth_position_jacobian(y).allFinite());
    EXPECT_EQ(linearity_index(y, 0.01, {0, 0, 1}), std::numeric_limits<double>::infinity());
  }
}

TEST(InverseDepth, LinearityIndexIsThatOfCivera) {
  // seen from where it began: d₁ = 4 m, cos α = 1, so L = 4 (σ/ρ²)/d₁ = 4 σ/ρ
  EXPECT_NEAR(linearity_index(parameters(), 0.01, parameters().head<3>()), 4 * 0.01 / 0.25, 1e-13);
  // from 3 m to the side of the line of sight: d₁ = 5 m, cos α = 4/5
  const Eigen::Vector3d m = bearing(0.7, -0.2), side = m.cross(Eigen::Vector3d::UnitZ()).normalized();
  EXPECT_NEAR(linearity_index(parameters(), 0.01, parameters().head<3>() + 3 * side),
              4 * 0.01 / (0.25 * 0.25) * 0.8 / 5, 1e-13);
}

}  // namespace
}  // namespace slam
