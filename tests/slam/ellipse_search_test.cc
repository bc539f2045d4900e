#include "slam/vision/patch.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

double correlation(const cv::Mat& a, const Eigen::Vector2i& p, const cv::Mat& b, const Eigen::Vector2i& q) {
  cv::Mat result;
  const auto box = [](const Eigen::Vector2i& c) { return cv::Rect(c.x() - 5, c.y() - 5, 11, 11); };
  cv::matchTemplate(b(box(q)), a(box(p)), result, cv::TM_CCOEFF_NORMED);
  return result.at<float>(0, 0);
}

TEST(EllipseSearch, FindsWhatTheSearchOfEveryPixelWithOpenCvFinds) {
  const cv::Mat first = pattern(0, 0), now = pattern(3, -2);
  const Eigen::Vector2i at(70, 60);
  const Eigen::Vector2d center(71.3, 59.6);
  Eigen::Matrix2d S;
  S << 4, 1.5, 1.5, 3;
  const auto found = search_ellipse(now, template_at(first, at), center, S, 3);
  ASSERT_TRUE(found);
  double best = -1;
  Eigen::Vector2i where(0, 0);
  for (int v = 20; v < 100; ++v)
    for (int u = 20; u < 140; ++u) {
      const Eigen::Vector2d nu = Eigen::Vector2d(u, v) - center;
      if (nu.dot(S.inverse() * nu) > 9) continue;
      const double c = correlation(first, at, now, {u, v});
      if (c > best) best = c, where = {u, v};
    }
  EXPECT_EQ(found->pixel, where.cast<double>());
  EXPECT_NEAR(found->correlation, best, 1e-5);  // single precision
}

TEST(EllipseSearch, LooksNowhereOutsideTheEllipse) {
  const cv::Mat image = pattern(0, 0);
  const auto found =
      search_ellipse(image, template_at(image, {70, 60}), {80, 60}, Eigen::Matrix2d::Identity(), 3);
  ASSERT_TRUE(found);
  EXPECT_LE((found->pixel - Eigen::Vector2d(80, 60)).norm(), 3);
}

TEST(EllipseSearch, StaysInsideTheImageAndItsCostBounded) {
  const cv::Mat image = pattern(0, 0);
  const Template t = template_at(image, {70, 60});
  EXPECT_TRUE(search_ellipse(image, t, {4, 4}, 1e6 * Eigen::Matrix2d::Identity(), 3));
  EXPECT_FALSE(search_ellipse(image, t, {-60, 60}, Eigen::Matrix2d::Identity(), 3));
}

TEST(EllipseSearch, FindsNothingInAFlatImage) {
  const cv::Mat flat(120, 160, CV_8UC1, cv::Scalar(90));
  EXPECT_FALSE(
      search_ellipse(flat, template_at(pattern(0, 0), {70, 60}), {70, 60}, Eigen::Matrix2d::Identity(), 3));
}

}  // namespace
}  // namespace slam
