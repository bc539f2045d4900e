#include "slam/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/numerical_jacobian.h"

namespace slam {
namespace {

using tests::numerical_jacobian;

constexpr double kCentral =
    1e-6;  // px: differences of 1e-6 leave the rounding of pixels, 1e-13/1e-6, with room

/// The camera of the published MonoSLAM code.
CameraIntrinsics reference() { return {320, 240, 195, 195, 162, 125, 9e-6}; }

TEST(Camera, ProjectsTheReferencePointWithTheReferenceJacobian) {
  const auto p = Camera(reference()).project({0.4, -0.3, 2.0});
  ASSERT_TRUE(p);
  Matrix23d J;
  J << 92.9723824473, 1.8800947213, -18.3124622813, 1.8800947213, 94.0691043680, 13.7343467110;
  EXPECT_NEAR((p->pixel - Eigen::Vector2d(200.1916701636, 96.3562473773)).norm(), 0,
              1e-9);  // digits of the reference
  EXPECT_NEAR((p->J - J).norm(), 0, 1e-9);
}

TEST(Camera, JacobiansAreTheDerivativesAllOverTheImage) {
  const Camera camera(CameraIntrinsics{});
  for (const double u : {1.0, 80.0, 157.0, 240.0, 318.0})
    for (const double v : {1.0, 127.0, 238.0}) {
      const auto ray = camera.unproject({u, v});
      ASSERT_TRUE(ray);
      const Eigen::Vector3d h = 2.5 * ray->h;
      const auto of_h = numerical_jacobian(
          [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return camera.project(x)->pixel; }, h);
      const auto of_pixel = numerical_jacobian(
          [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return camera.unproject(x)->h; },
          Eigen::Vector2d(u, v));
      EXPECT_NEAR((camera.project(h)->J - of_h).norm(), 0, kCentral);
      EXPECT_NEAR((ray->J - of_pixel).norm(), 0, kCentral);
    }
}

TEST(Camera, UnprojectUndoesProjectExactly) {
  const Camera camera(CameraIntrinsics{});
  for (const double x : {-1.0, -0.2, 0.0, 0.7})
    for (const double y : {-0.7, 0.0, 0.6}) {
      const auto p = camera.project({x * 3, y * 3, 3});
      ASSERT_TRUE(p);
      EXPECT_NEAR((camera.unproject(p->pixel)->h - Eigen::Vector3d(x, y, 1)).norm(), 0, 1e-13);
    }
}

TEST(Camera, SeesAboutNinetyTwoDegreesAcross) {
  const Camera camera(CameraIntrinsics{});
  const auto left = camera.unproject({0, 127})->h, right = camera.unproject({319, 127})->h;
  EXPECT_NEAR(std::acos(left.normalized().dot(right.normalized())) * 57.2958, 91.6,
              0.5);  // the camera's data sheet
}

TEST(Camera, GivesNothingForPointsBehindOrInItsPlane) {
  const Camera camera(CameraIntrinsics{});
  EXPECT_FALSE(camera.project({0.1, 0.2, -1}));
  EXPECT_FALSE(camera.project({1, 0, 0}));
  EXPECT_FALSE(camera.project({0, 0, 0}));
}

TEST(Camera, GivesNothingOutsideTheImageCircleOfItsLens) {
  EXPECT_FALSE(Camera(CameraIntrinsics{}).unproject({1000, 1000}));
}

TEST(Camera, NoiseDoublesFromTheCentreToTheCorner) {
  const Camera camera(reference());
  EXPECT_DOUBLE_EQ(camera.sigma({162, 125}, 0.7), 0.7);
  EXPECT_DOUBLE_EQ(camera.sigma({0, 0}, 0.7), 1.4);
}

TEST(Camera, RefusesALensThatIsNone) {
  CameraIntrinsics bad;
  bad.fu_px = 0;
  EXPECT_THROW(Camera{bad}, std::invalid_argument);
  bad = {};
  bad.k1_px2 = -1e-6;
  EXPECT_THROW(Camera{bad}, std::invalid_argument);
}

TEST(Camera, JacobiansOfBothWaysUndoEachOther) {
  const Camera camera(CameraIntrinsics{});
  const auto ray = camera.unproject({60, 200});
  EXPECT_LT((camera.project(ray->h)->J * ray->J - Eigen::Matrix2d::Identity()).norm(), 1e-12);
}

TEST(Camera, ProjectionDoesNotFeelTheLengthOfItsVector) {
  const Camera camera(CameraIntrinsics{});
  const Eigen::Vector3d h(0.4, -0.3, 1.7);
  EXPECT_LT((camera.project(1e-9 * h)->pixel - camera.project(1e9 * h)->pixel).norm(), 1e-10);
}

TEST(Camera, GivesNothingForWhatIsNotANumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Camera(CameraIntrinsics{}).project({1, 1, nan}));
  EXPECT_FALSE(Camera(CameraIntrinsics{}).project({nan, 1, 1}));
  EXPECT_FALSE(Camera(CameraIntrinsics{}).unproject({nan, 1}));
}

TEST(Camera, NoiseGrowsLinearlyInBetween) {
  EXPECT_DOUBLE_EQ(Camera(reference()).sigma({81, 62.5}, 0.7), 1.05);
}

TEST(Camera, InsideCountsTheMarginOnEverySide) {
  const Camera camera(CameraIntrinsics{});
  EXPECT_TRUE(camera.inside({7, 7}, 7));
  EXPECT_TRUE(camera.inside({312, 232}, 7));
  for (const Eigen::Vector2d& out : {Eigen::Vector2d(6.9, 100), {312.1, 100}, {100, 6.9}, {100, 232.1}})
    EXPECT_FALSE(camera.inside(out, 7)) << out.transpose();
}

}  // namespace
}  // namespace slam
