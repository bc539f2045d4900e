// Images of known content and a camera pose that several tests use.
#pragma once

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <random>

#include "slam/vision/patch.h"
#include "slam/state.h"

namespace slam {

/// Smooth noise whose value is known everywhere, so that it can be drawn shifted below the pixel.
inline cv::Mat pattern(double dx, double dy) {
  cv::Mat image(120, 160, CV_8UC1);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const double x = u - dx, y = v - dy;
      image.ptr<uchar>(v)[u] = static_cast<uchar>(
          std::lround(127 + 40 * std::sin(0.31 * x + 0.17 * y) + 35 * std::sin(0.23 * y - 0.38 * x + 1) +
                      30 * std::cos(0.045 * x * std::sin(0.05 * y) + 0.41 * y)));
    }
  return image;
}

/// The mean of a robot at rest whose camera looks along +x of W.
inline RobotVector looking_ahead(const Eigen::Vector3d& p_WC = {0, 0, 1.4}) {
  RobotVector x = RobotVector::Zero();
  x.segment<3>(kPosition) = p_WC;
  x.segment<4>(kOrientation) << 0.5, -0.5, 0.5, -0.5;
  return x;
}

/// Blocks of `side` px of random gray: corners everywhere.
inline cv::Mat random_blocks(int columns, int side, std::uint64_t seed) {
  cv::Mat image(240, columns, CV_8UC1);
  std::mt19937_64 random(seed);
  for (int row = 0; row < image.rows; row += side)
    for (int column = 0; column < image.cols; column += side)
      image(cv::Rect(column, row, side, side) & cv::Rect(0, 0, image.cols, image.rows))
          .setTo(cv::Scalar(static_cast<double>(random() % 256)));
  return image;
}

inline Template template_at(const cv::Mat& image, const Eigen::Vector2i& pixel) {
  return warp(cut_patch(image, pixel), Eigen::Matrix2d::Identity()).value();
}

}  // namespace slam
