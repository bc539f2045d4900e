#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

/// The camera of the published MonoSLAM code.
CameraIntrinsics reference() { return {320, 240, 195, 195, 162, 125, OneParameterRadial{9e-6}}; }

TEST(Camera, ProjectsTheReferencePointWithTheReferenceJacobian) {
  const auto p = Camera(reference()).project({0.4, -0.3, 2.0});
  ASSERT_TRUE(p);
  Matrix23d J;
  J << 92.9723824473, 1.8800947213, -18.3124622813, 1.8800947213, 94.0691043680, 13.7343467110;
  EXPECT_LT((p->pixel - Eigen::Vector2d(200.1916701636, 96.3562473773)).norm(), 1e-9);  // its digits
  EXPECT_NEAR((p->J - J).norm(), 0, 1e-9);
}

// By the formulas of OpenCV's manual, computed independently.
TEST(Camera, BrownsLensAndTheEquidistantOneProjectAsOpenCvDefinesThem) {
  const Eigen::Vector2d brown(576.385155769302, 123.276240971480),
      fisheye(402.426039072004, 163.183429681452);
  EXPECT_LT((Camera(kBrown).project({1, -0.6, 2})->pixel - brown).norm(), 1e-9);
  EXPECT_LT((Camera(kFisheye).project({2.2, -1.4, 2})->pixel - fisheye).norm(), 1e-9);
}

TEST(Camera, UnprojectUndoesProjectExactly) {
  for (const CameraIntrinsics& intrinsics : {CameraIntrinsics{}, kBrown, kFisheye}) {
    const Camera camera(intrinsics);
    for (const double x : {-1.0, -0.2, 0.0, 0.7})
      for (const double y : {-0.7, 0.0, 0.6}) {
        const double length = x < 0 ? 3e-9 : 3e9;  // any
        const auto p = camera.project(length * Eigen::Vector3d(x, y, 1));
        ASSERT_TRUE(p);
        EXPECT_NEAR((camera.unproject(p->pixel)->h - Eigen::Vector3d(x, y, 1)).norm(), 0, 1e-13);
      }
  }
}

TEST(Camera, APointBeyondTheFoldOfItsLensIsNotSeen) {
  CameraIntrinsics folding = kBrown;
  folding.lens = RadialTangential{-0.3, 0, 0, 0};  // r (1 - 0.3 r²) is largest at r = 1.054
  const Camera camera(folding);
  EXPECT_TRUE(camera.project({1.05, 0, 1}));
  EXPECT_FALSE(camera.project({1.06, 0, 1}));
  EXPECT_FALSE(camera.project({1.8, 0, 1}));  // would land in the middle of the image
  EXPECT_FALSE(camera.unproject({367.215 + 458.654 * 0.71, 248.375}));  // the largest image is at 0.7027
}

TEST(Camera, GivesNothingForPointsBehindOrInItsPlaneOutsideTheImageCircleAndForNan) {
  const Camera camera(CameraIntrinsics{});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Eigen::Vector3d& h :
       {Eigen::Vector3d(1, 1, nan), {nan, 1, 1}, {0.1, 0.2, -1}, {1, 0, 0}, {0, 0, 0}})
    EXPECT_FALSE(camera.project(h)) << h.transpose();
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(nan, 1), {1000, 1000}})
    EXPECT_FALSE(camera.unproject(pixel)) << pixel.transpose();
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
  for (const Lens& lens : {Lens(OneParameterRadial{-1e-6}), Lens(RadialTangential{-1000, 0, 0, 0}),
                           Lens(Equidistant{std::numeric_limits<double>::quiet_NaN(), 0, 0, 0})})
    EXPECT_THROW(Camera({320, 240, 197, 195, 157, 127, lens}), std::invalid_argument) << lens.index();
}

TEST(Camera, InsideCountsTheMarginOnEverySide) {
  const Camera camera(CameraIntrinsics{});
  EXPECT_TRUE(camera.inside({7, 7}, 7));
  EXPECT_TRUE(camera.inside({312, 232}, 7));
  for (const Eigen::Vector2d& out : {Eigen::Vector2d(6.9, 100), {312.1, 100}, {100, 6.9}, {100, 232.1}})
    EXPECT_FALSE(camera.inside(out, 7)) << out.transpose();
}

TEST(Rotation, ExponentialLogarithmAndMatrixAgreeWithEigen) {
  for (const double scale : {1.0, 1e-3, 1e-9, 0.0}) {
    const Eigen::Vector3d theta = scale * Eigen::Vector3d(0.3, -0.7, 1.1);
    const Eigen::Vector4d q = quaternion_exp(theta);
    const Eigen::Quaterniond expected(Eigen::AngleAxisd(theta.norm(), theta.stableNormalized()));
    EXPECT_NEAR((q - Eigen::Vector4d(expected.w(), expected.x(), expected.y(), expected.z())).norm(), 0,
                1e-15);
    EXPECT_NEAR((rotation_matrix(q) - expected.toRotationMatrix()).norm(), 0, 1e-15);
    EXPECT_NEAR((quaternion_log(q) - theta).norm(), 0, 1e-15);
    EXPECT_NEAR((quaternion_log(-q) - theta).norm(), 0, 1e-15);
  }
}

}  // namespace
}  // namespace slam
