#include "slam/corner_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "slam/patch.h"

namespace slam {
namespace {

constexpr std::size_t kOnStack = 1024;  // columns, as many as images have

/// Σ over a column of 11 pixels of gx², gxgy, gy², each gradient twice its value so that all stays integer.
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

/// The smaller eigenvalue, in the units of the halved gradients.
double smaller_eigenvalue(const Moments& m) {
  const double xx = m.xx, xy = m.xy, yy = m.yy;
  return (xx + yy - std::sqrt((xx - yy) * (xx - yy) + 4 * xy * xy)) / 8;
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

}  // namespace slam
