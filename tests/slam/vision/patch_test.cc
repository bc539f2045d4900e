#include "slam/vision/patch.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

TEST(Patch, RefinesToAFewHundredthsOfAPixelAtAnyBrightnessAndContrast) {
  const Template t = template_at(pattern(0, 0), {70, 60});
  for (const double shift : {0.1, 0.35, 0.5, 0.8})
    for (const double contrast : {1.0, 0.5}) {
      cv::Mat image;
      pattern(shift, -shift / 2).convertTo(image, CV_8U, contrast, 20 * (1 - contrast));
      const auto match = refine(image, t, {70, 60});
      ASSERT_TRUE(match);
      EXPECT_NEAR(match->pixel.x(), 70 + shift, 0.05);  // gray values are whole numbers, samples bilinear
      EXPECT_NEAR(match->pixel.y(), 60 - shift / 2, 0.05);
      EXPECT_GT(match->correlation, 0.99);
    }
}

TEST(Patch, FlatPatchesMakeNoTemplateAndAreNotFound) {
  const cv::Mat flat(120, 160, CV_8UC1, cv::Scalar(90));
  const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
  EXPECT_FALSE(warp(cut_patch(flat, {70, 60}), I));
  EXPECT_FALSE(search_ellipse(flat, template_at(pattern(0, 0), {70, 60}), {70, 60}, I, 3));
}

TEST(Patch, ViewChangeIsTheDerivativeThroughTheSurface) {
  const Camera camera(CameraIntrinsics{});
  Eigen::Isometry3d first = Eigen::Isometry3d::Identity(), now = first;
  now.linear() =
      (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  now.translation() = Eigen::Vector3d(-0.5, 0.1, 0.4);
  const Eigen::Vector3d p(0.6, -0.3, 3);
  const Eigen::Vector2d pixel = camera.project(now.inverse() * p)->pixel;
  const Eigen::Vector3d normal = surface_normal(first, p, {0.7, -0.4});
  const auto A = view_change(camera, first, now, p, normal, pixel);
  ASSERT_TRUE(A);
  const auto through =
      [&](const Eigen::Vector2d& u) -> Eigen::Vector2d {  // pixel now -> surface -> pixel first
    const Eigen::Vector3d line = now.linear() * camera.unproject(u)->h;
    const double s = normal.dot(p - now.translation()) / normal.dot(line);
    return camera.project(first.inverse() * (now.translation() + s * line))->pixel;
  };
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d e = 1e-4 * Eigen::Vector2d::Unit(i);
    EXPECT_NEAR((A->col(i) - (through(pixel + e) - through(pixel - e)) / 2e-4).norm(), 0, 1e-6);
  }
}

TEST(Patch, ASurfaceIsTurnedByTheAnglesOfItsTilt) {
  Eigen::Isometry3d first = Eigen::Isometry3d::Identity();
  first.translation() = Eigen::Vector3d(1, 2, 3);
  const Eigen::Vector3d p(1, 2, 7);
  EXPECT_LT((surface_normal(first, p, {0, 0}) - Eigen::Vector3d(0, 0, -1)).norm(), 1e-12);
  const Eigen::Vector3d right = surface_normal(first, p, {std::tan(0.5), 0});
  EXPECT_LT((right - Eigen::Vector3d(std::sin(0.5), 0, -std::cos(0.5))).norm(), 1e-12);
  const Eigen::Vector3d down = surface_normal(first, p, {0, std::tan(0.5)});
  EXPECT_LT((down - Eigen::Vector3d(0, std::sin(0.5), -std::cos(0.5))).norm(), 1e-12);
}

TEST(Patch, SurfacesSeenTooObliquelyAreNotMatched) {
  const Camera camera(CameraIntrinsics{});
  Eigen::Isometry3d now = Eigen::Isometry3d::Identity();
  now.linear() = Eigen::AngleAxisd(-1.4, Eigen::Vector3d::UnitY()).toRotationMatrix();
  now.translation() = Eigen::Vector3d(3, 0, 3.2);
  const Eigen::Vector3d p(0, 0, 3);
  const auto seen = camera.project(now.inverse() * p);
  ASSERT_TRUE(seen);
  const Eigen::Isometry3d first = Eigen::Isometry3d::Identity();
  EXPECT_FALSE(view_change(camera, first, now, p, surface_normal(first, p, {0, 0}), seen->pixel));
}

TEST(EllipseSearch, FindsWhatTheSearchOfEveryPixelWithOpenCvFinds) {
  const cv::Mat first = pattern(0, 0), now = pattern(3, -2);
  const Eigen::Vector2i at(70, 60);
  const Eigen::Vector2d center(71.3, 59.6);
  Eigen::Matrix2d S;
  S << 4, 1.5, 1.5, 3;
  const auto found = search_ellipse(now, template_at(first, at), center, S, 3);
  ASSERT_TRUE(found);
  cv::Mat scores;
  cv::matchTemplate(now, first(cv::Rect(at.x() - 5, at.y() - 5, 11, 11)), scores, cv::TM_CCOEFF_NORMED);
  double best = -1;
  Eigen::Vector2i where(0, 0);
  for (int v = 20; v < 100; ++v)
    for (int u = 20; u < 140; ++u) {
      const Eigen::Vector2d nu = Eigen::Vector2d(u, v) - center;
      if (nu.dot(S.inverse() * nu) > 9) continue;
      const double c = scores.at<float>(v - 5, u - 5);
      if (c > best) best = c, where = {u, v};
    }
  EXPECT_EQ(found->pixel, where.cast<double>());
  EXPECT_NEAR(found->correlation, best, 1e-5);  // single precision
}

TEST(EllipseSearch, StaysInsideTheImageAndItsCostBounded) {
  const cv::Mat image = pattern(0, 0);
  const Template t = template_at(image, {70, 60});
  EXPECT_TRUE(search_ellipse(image, t, {4, 4}, 1e6 * Eigen::Matrix2d::Identity(), 3));
  EXPECT_FALSE(search_ellipse(image, t, {-60, 60}, Eigen::Matrix2d::Identity(), 3));
}

}  // namespace
}  // namespace slam
