#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "slam/camera.h"
#include "slam/rotation.h"

namespace slam {
namespace {

/// The camera of the published MonoSLAM code.
CameraIntrinsics reference() { return {320, 240, 195, 195, 162, 125, OneParameterRadial{9e-6}}; }

TEST(Camera, ProjectsTheReferencePointWithTheReferenceJacobian) {
  const auto p = Camera(reference()).project({0.4, -0.3, 2.0});
  ASSERT_TRUE(p);
  Matrix23d J;
  J << 92.9723824473, 1.8800947213, -18.3124622813, 1.8800947213, 94.0691043680, 13.7343467110;
  EXPECT_NEAR((p->pixel - Eigen::Vector2d(200.1916701636, 96.3562473773)).norm(), 0,
              1e-9);  // digits of the reference
  EXPECT_NEAR((p->J - J).norm(), 0, 1e-9);
}

/// The camera of the EuRoC flying robot, and one behind a fisheye of the same field as the default camera.
CameraIntrinsics brown() {
  return {752,
          480,
          458.654,
          457.296,
          367.215,
          248.375,
          RadialTangential{-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
}
CameraIntrinsics fisheye() {
  return {512, 512, 191, 191, 255, 257, Equidistant{-0.0027, 0.0019, -0.0016, 0.0002}};
}

// By the formulas of OpenCV's manual, computed independently.
TEST(Camera, BrownsLensAndTheEquidistantOneProjectAsOpenCvDefinesThem) {
  EXPECT_NEAR(
      (Camera(brown()).project({1, -0.6, 2})->pixel - Eigen::Vector2d(576.385155769302, 123.276240971480))
          .norm(),
      0, 1e-9);
  EXPECT_NEAR(
      (Camera(fisheye()).project({2.2, -1.4, 2})->pixel - Eigen::Vector2d(402.426039072004, 163.183429681452))
          .norm(),
      0, 1e-9);
}

TEST(Camera, UnprojectUndoesProjectExactly) {
  for (const CameraIntrinsics& intrinsics : {CameraIntrinsics{}, brown(), fisheye()}) {
    const Camera camera(intrinsics);
    for (const double x : {-1.0, -0.2, 0.0, 0.7})
      for (const double y : {-0.7, 0.0, 0.6}) {
        const auto p = camera.project({x * 3, y * 3, 3});
        ASSERT_TRUE(p);
        EXPECT_NEAR((camera.unproject(p->pixel)->h - Eigen::Vector3d(x, y, 1)).norm(), 0, 1e-13);
      }
  }
}

TEST(Camera, APointBeyondTheFoldOfItsLensIsNotSeen) {
  CameraIntrinsics folding = brown();
  folding.lens = RadialTangential{-0.3, 0, 0, 0};  // r (1 - 0.3 r²) is largest at r = 1.054
  const Camera camera(folding);
  EXPECT_TRUE(camera.project({1.05, 0, 1}));
  EXPECT_FALSE(camera.project({1.06, 0, 1}));
  EXPECT_FALSE(camera.project({1.8, 0, 1}));  // would land in the middle of the image
  EXPECT_FALSE(camera.unproject({367.215 + 458.654 * 0.71, 248.375}));  // the largest image is at 0.7027
}

TEST(Camera, SeesAboutNinetyTwoDegreesAcross) {
  const Camera camera(CameraIntrinsics{});
  const auto left = camera.unproject({0, 127})->h, right = camera.unproject({319, 127})->h;
  EXPECT_NEAR(std::acos(left.normalized().dot(right.normalized())) * 57.2958, 91.6,
              0.5);  // the camera's data sheet
}

TEST(Camera, GivesNothingForPointsBehindOrInItsPlaneOutsideTheImageCircleAndForNan) {
  const Camera camera(CameraIntrinsics{});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(camera.project({1, 1, nan}));
  EXPECT_FALSE(camera.project({nan, 1, 1}));
  EXPECT_FALSE(camera.unproject({nan, 1}));
  EXPECT_FALSE(camera.unproject({1000, 1000}));
  EXPECT_FALSE(camera.project({0.1, 0.2, -1}));
  EXPECT_FALSE(camera.project({1, 0, 0}));
  EXPECT_FALSE(camera.project({0, 0, 0}));
}

TEST(Camera, NoiseGrowsLinearlyToTwiceItsSizeFromTheCentreToTheCorner) {
  const Camera camera(reference());
  EXPECT_DOUBLE_EQ(camera.sigma({162, 125}, 0.7), 0.7);
  EXPECT_DOUBLE_EQ(camera.sigma({81, 62.5}, 0.7), 1.05);
  EXPECT_DOUBLE_EQ(camera.sigma({0, 0}, 0.7), 1.4);
}

TEST(Camera, RejectsInvalidLenses) {
  CameraIntrinsics bad;
  bad.fu_px = 0;
  EXPECT_THROW(Camera{bad}, std::invalid_argument);
  bad = {};
  bad.lens = OneParameterRadial{-1e-6};
  EXPECT_THROW(Camera{bad}, std::invalid_argument);
  bad.lens = RadialTangential{-1000, 0, 0, 0};
  EXPECT_THROW(Camera{bad}, std::invalid_argument);
  bad.lens = Equidistant{std::numeric_limits<double>::quiet_NaN(), 0, 0, 0};
  EXPECT_THROW(Camera{bad}, std::invalid_argument);
}

TEST(Camera, ProjectionDoesNotDependOnTheLengthOfItsVector) {
  const Camera camera(CameraIntrinsics{});
  const Eigen::Vector3d h(0.4, -0.3, 1.7);
  EXPECT_LT((camera.project(1e-9 * h)->pixel - camera.project(1e9 * h)->pixel).norm(), 1e-10);
}

TEST(Camera, InsideCountsTheMarginOnEverySide) {
  const Camera camera(CameraIntrinsics{});
  EXPECT_TRUE(camera.inside({7, 7}, 7));
  EXPECT_TRUE(camera.inside({312, 232}, 7));
  for (const Eigen::Vector2d& out : {Eigen::Vector2d(6.9, 100), {312.1, 100}, {100, 6.9}, {100, 232.1}})
    EXPECT_FALSE(camera.inside(out, 7)) << out.transpose();
}

TEST(Rotation, ExponentialAgreesWithEigensAngleAxis) {
  const Eigen::Vector3d theta(0.3, -0.7, 1.1);
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(theta.norm(), theta.normalized()));
  const Eigen::Vector4d q = quaternion_exp(theta);
  EXPECT_NEAR((q - Eigen::Vector4d(expected.w(), expected.x(), expected.y(), expected.z())).norm(), 0, 1e-15);
}

TEST(Rotation, LogarithmUndoesTheExponentialAndIgnoresTheQuaternionsSign) {
  for (const double scale : {1.0, 1e-3, 1e-9, 0.0}) {
    const Eigen::Vector3d theta = scale * Eigen::Vector3d(0.3, -0.7, 1.1);
    EXPECT_NEAR((quaternion_log(quaternion_exp(theta)) - theta).norm(), 0, 1e-15);
    EXPECT_NEAR((quaternion_log(-quaternion_exp(theta)) - theta).norm(), 0, 1e-15);
  }
}

TEST(Rotation, MatrixOfAUnitQuaternionIsEigens) {
  const Eigen::Vector4d q = Eigen::Vector4d(0.9, 0.1, -0.2, 0.3).normalized();
  EXPECT_NEAR((rotation_matrix(q) - Eigen::Quaterniond(q(0), q(1), q(2), q(3)).toRotationMatrix()).norm(), 0,
              1e-15);
}

}  // namespace
}  // namespace slam
