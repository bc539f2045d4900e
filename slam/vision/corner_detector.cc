#include "slam/vision/corner_detector.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "slam/vision/patch.h"

namespace slam {
namespace {

constexpr std::size_t kOnStack = 1024;    // columns, more than regions have
constexpr double kLeastDistance_px = 20;  // between the corners of two landmarks
constexpr double kFewVisible = 12;        // up to so many landmarks a box has a quarter of the image's sides
constexpr double kCornerGateSigmas = 3;

/// Σ gx², gxgy, gy² over a column of 11 pixels, with doubled gradients so that the sums are integers.
struct Moments {
  std::int32_t xx = 0, xy = 0, yy = 0;
  void add(const Moments& other, std::int32_t sign) {
    xx += sign * other.xx;
    xy += sign * other.xy;
    yy += sign * other.yy;
  }
};

Moments moments_at(const cv::Mat& image, int row, int column) {
  const std::int32_t gx = image.ptr<uchar>(row)[column + 1] - image.ptr<uchar>(row)[column - 1];
  const std::int32_t gy = image.ptr<uchar>(row + 1)[column] - image.ptr<uchar>(row - 1)[column];
  return {gx * gx, gx * gy, gy * gy};
}

/// The smaller eigenvalue of the moments of the actual gradients.
double smaller_eigenvalue(const Moments& m) {
  const double xx = m.xx, xy = m.xy, yy = m.yy;
  return (xx + yy - std::sqrt((xx - yy) * (xx - yy) + 4 * xy * xy)) / 8;
}

/// A box at a random place, smaller if more landmarks are wanted, so that they are apart.
cv::Rect random_box(const cv::Mat& image, int visible, std::mt19937_64& random) {
  const int margin = kSourceHalf + 1;
  const double side = std::min(1.0, std::sqrt(kFewVisible / visible)) / 4;  // relative to the image's
  const int width = static_cast<int>(side * image.cols), height = static_cast<int>(side * image.rows);
  const auto below = [&random](int n) { return static_cast<int>(random() % static_cast<std::uint64_t>(n)); };
  const int x = margin + below(image.cols - 2 * margin - width + 1);
  const int y = margin + below(image.rows - 2 * margin - height + 1);
  return {x, y, width, height};
}

}  // namespace

std::optional<Corner> strongest_corner(const cv::Mat& image, const cv::Rect& region, double threshold) {
  const int margin = kPatchHalf + 1;
  const cv::Rect inside = region & cv::Rect(margin, margin, image.cols - 2 * margin, image.rows - 2 * margin);
  if (inside.area() == 0) return std::nullopt;
  const int left = inside.x - kPatchHalf, columns = inside.width + 2 * kPatchHalf;
  cv::AutoBuffer<Moments, kOnStack> sums(static_cast<std::size_t>(columns));
  std::fill_n(sums.data(), columns, Moments{});
  const auto add_row = [&](int row, std::int32_t sign) {
    for (int i = 0; i < columns; ++i)
      sums[static_cast<std::size_t>(i)].add(moments_at(image, row, left + i), sign);
  };
  for (int row = inside.y - kPatchHalf; row < inside.y + kPatchHalf; ++row) add_row(row, 1);
  std::optional<Corner> best;
  for (int row = inside.y; row < inside.y + inside.height; ++row) {
    add_row(row + kPatchHalf, 1);
    Moments window;
    for (int i = 0; i < columns; ++i) {
      window.add(sums[static_cast<std::size_t>(i)], 1);
      if (i >= kPatchSide) window.add(sums[static_cast<std::size_t>(i - kPatchSide)], -1);
      if (i < kPatchSide - 1) continue;
      const double strength = smaller_eigenvalue(window);
      if (strength > threshold && (!best || strength > best->strength))
        best = Corner{{left + i - kPatchHalf, row}, strength};
    }
    add_row(row - kPatchHalf, -1);
  }
  return best;
}

std::optional<Eigen::Vector2i> propose_corner(const cv::Mat& image,
                                              const std::vector<Eigen::Vector2d>& occupied,
                                              const Options::Vision& options, std::mt19937_64& random) {
  const cv::Rect box = random_box(image, options.visible_landmarks, random);
  if (std::any_of(occupied.begin(), occupied.end(),
                  [&](const Eigen::Vector2d& p) { return box.contains(cv::Point2d(p.x(), p.y())); }))
    return std::nullopt;
  const auto corner = strongest_corner(image, box, options.corner_threshold);
  if (!corner) return std::nullopt;
  const Eigen::Vector2d pixel = corner->pixel.cast<double>();
  const double least = std::min<double>(kLeastDistance_px, box.height);
  if (std::any_of(occupied.begin(), occupied.end(),
                  [&](const Eigen::Vector2d& p) { return (p - pixel).norm() < least; }))
    return std::nullopt;
  return corner->pixel;
}

std::optional<Eigen::Vector2d> corner_near(const cv::Mat& image, const Eigen::Vector2d& predicted,
                                           const Eigen::Matrix2d& S) {
  const cv::Point2f start(cv::Point2d(predicted.x(), predicted.y()));
  std::vector<cv::Point2f> at{start};
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.01);
  cv::cornerSubPix(image, at, {kPatchHalf, kPatchHalf}, {-1, -1}, criteria);
  const Eigen::Vector2d corner(at[0].x, at[0].y), moved = corner - predicted;
  if (at[0] == start || !(moved.dot(S.llt().solve(moved)) < kCornerGateSigmas * kCornerGateSigmas))
    return std::nullopt;
  return corner;
}

}  // namespace slam
