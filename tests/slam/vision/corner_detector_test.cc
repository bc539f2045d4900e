#include "slam/vision/corner_detector.h"

#include <gtest/gtest.h>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

TEST(CornerDetector, FindsOpenCvsStrongestCorner) {
  const cv::Mat image = pattern(0, 0);
  const cv::Rect region(30, 25, 80, 60);
  const auto corner = strongest_corner(image, region, 1000);
  ASSERT_TRUE(corner);
  double best = -1;
  Eigen::Vector2i where(0, 0);
  for (int v = region.y; v < region.y + region.height; ++v)
    for (int u = region.x; u < region.x + region.width; ++u) {
      cv::Matx22d M = cv::Matx22d::zeros();
      for (int j = -5; j <= 5; ++j)
        for (int i = -5; i <= 5; ++i) {
          const auto g = [&](int a, int b) {
            return static_cast<double>(image.at<uchar>(v + j + b, u + i + a));
          };
          const cv::Vec2d d((g(1, 0) - g(-1, 0)) / 2, (g(0, 1) - g(0, -1)) / 2);
          M += d * d.t();
        }
      cv::Vec2d eigenvalues;  // the smaller one is the second
      cv::eigen(M, eigenvalues);
      const double strength = eigenvalues(1);
      if (strength > best) best = strength, where = {u, v};
    }
  EXPECT_EQ(corner->pixel, where);
  EXPECT_NEAR(corner->strength, best, 1e-9 * best);
}

TEST(CornerDetector, FindsNothingInAFlatRegion) {
  EXPECT_FALSE(strongest_corner(cv::Mat(120, 160, CV_8UC1, cv::Scalar(90)), {0, 0, 160, 120}, 1));
}

TEST(CornerDetector, ProposesCornersAwayFromOccupiedPixels) {
  const cv::Mat image = random_blocks(320, 8, 5);
  std::mt19937_64 random(1);
  std::vector<Eigen::Vector2d> occupied;
  for (int k = 0; k < 60; ++k)
    if (const auto corner = propose_corner(image, occupied, Options::Vision{}, random))
      occupied.push_back(corner->cast<double>());
  EXPECT_GE(occupied.size(), 8u);
  for (std::size_t i = 0; i < occupied.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE((occupied[i] - occupied[j]).norm(), 20);
}

TEST(CornerDetector, ProposesNothingInAFlatImage) {
  std::mt19937_64 random(1);
  for (int k = 0; k < 20; ++k)
    EXPECT_FALSE(propose_corner(cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)), {}, Options::Vision{}, random));
}

TEST(CornerDetector, FindsTheCornerNearAPixelIfItLiesWithinThreeSigma) {
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(60));
  image(cv::Rect(160, 120, 160, 120)).setTo(cv::Scalar(200));  // its corner is at (159.5, 119.5)
  const Eigen::Vector2d near(161, 121);
  const auto corner = corner_near(image, near, Eigen::Matrix2d::Identity());
  ASSERT_TRUE(corner);
  EXPECT_LT((*corner - Eigen::Vector2d(159.5, 119.5)).norm(), 0.1);  // interpolation between pixels
  EXPECT_FALSE(corner_near(image, near, 0.01 * Eigen::Matrix2d::Identity()));
}

}  // namespace
}  // namespace slam
