#include "slam/ellipse_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace slam {
namespace {

constexpr int kWidest = 2 * kLargestSearch + 1;
constexpr int kTogether = 16;  // neighbouring correlations computed at once, in two registers of 8
using Lane = Eigen::Array<float, 8, 1>;

/// The range of pixels to search; its ends belong to it.
struct Box {
  int left, right, top, bottom;
};

Box search_box(const cv::Mat& image, const Eigen::Vector2d& centre, const Eigen::Vector2d& half) {
  const Eigen::Vector2d reach = half.cwiseMin(kLargestSearch);
  return {std::max(kPatchHalf, static_cast<int>(std::ceil(centre.x() - reach.x()))),
          std::min(image.cols - 1 - kPatchHalf, static_cast<int>(std::floor(centre.x() + reach.x()))),
          std::max(kPatchHalf, static_cast<int>(std::ceil(centre.y() - reach.y()))),
          std::min(image.rows - 1 - kPatchHalf, static_cast<int>(std::floor(centre.y() + reach.y())))};
}

/// Sums and sums of squares of 11 pixels of each column around the box, updated as the search moves down.
class ColumnSums {
 public:
  ColumnSums(const cv::Mat& image, const Box& box) : image_(image), left_(box.left - kPatchHalf) {
    columns_ = static_cast<std::size_t>(box.right - box.left + kPatchSide);
    for (int j = -kPatchHalf; j < kPatchHalf; ++j) add(box.top + j, 1);
  }
  void enter(int row) { add(row + kPatchHalf, 1); }
  void leave(int row) { add(row - kPatchHalf, -1); }
  std::int32_t sum(std::size_t i) const { return sum_[i]; }
  std::int32_t square(std::size_t i) const { return square_[i]; }

 private:
  void add(int row, std::int32_t sign) {
    const uchar* grey = image_.ptr<uchar>(row) + left_;
    for (std::size_t i = 0; i < columns_; ++i) {
      const std::int32_t g = grey[i];
      sum_[i] += sign * g;
      square_[i] += sign * g * g;
    }
  }
  const cv::Mat& image_;
  int left_;
  std::size_t columns_;
  std::array<std::int32_t, kWidest + 2 * kPatchHalf> sum_{}, square_{};
};

/// The grey values that the templates in a box cover, padded so that a whole register can be read past them.
class Window {
 public:
  Window(const cv::Mat& image, const Box& box) {
    const int columns = box.right - box.left + kPatchSide, rows = box.bottom - box.top + kPatchSide;
    for (int j = 0; j < rows; ++j) {
      std::copy_n(image.ptr<uchar>(box.top - kPatchHalf + j) + box.left - kPatchHalf, columns, row(j));
      std::fill_n(row(j) + columns, kTogether, 0.0F);
    }
  }

  /// Correlates the template with the window at kTogether places from (top, column) of the box on.
  void products(const Template& patch, int top, int column, float* sums) const {
    Lane a = Lane::Zero(), b = a, c = a, d = a;  // four independent sums hide the latency of additions
    for (int j = 0; j < kPatchSide; ++j) {
      const float* t = patch.grey.data() + j * kPatchSide;
      const float* g = row(top + j) + column;
      for (int i = 0; i + 1 < kPatchSide; i += 2) {
        a += t[i] * lane(g + i);
        b += t[i] * lane(g + i + 8);
        c += t[i + 1] * lane(g + i + 1);
        d += t[i + 1] * lane(g + i + 9);
      }
      a += t[kPatchSide - 1] * lane(g + kPatchSide - 1);
      b += t[kPatchSide - 1] * lane(g + kPatchSide + 7);
    }
    Eigen::Map<Eigen::Array<float, kTogether, 1>>{sums} << a + c, b + d;
  }

 private:
  static constexpr int kStride = kWidest + 2 * kPatchHalf + kTogether;
  static Eigen::Map<const Lane> lane(const float* grey) { return Eigen::Map<const Lane>(grey); }
  float* row(int j) { return grey_.data() + j * kStride; }
  const float* row(int j) const { return grey_.data() + j * kStride; }

  std::array<float, static_cast<std::size_t>(kStride*(kWidest + 2 * kPatchHalf))> grey_;
};

}  // namespace

int searched_pixels(const Eigen::Matrix2d& S, double sigmas) {
  const Eigen::Vector2d reach = (sigmas * S.diagonal().cwiseSqrt()).cwiseMin(kLargestSearch);
  return (2 * static_cast<int>(reach.x()) + 1) * (2 * static_cast<int>(reach.y()) + 1);
}

std::optional<Match> search_ellipse(const cv::Mat& image, const Template& patch,
                                    const Eigen::Vector2d& centre, const Eigen::Matrix2d& S, double sigmas) {
  const Box box = search_box(image, centre, sigmas * S.diagonal().cwiseSqrt());
  if (box.left > box.right || box.top > box.bottom) return std::nullopt;
  const Eigen::Matrix2d A = S.inverse() / (sigmas * sigmas);
  constexpr double kPixels = Template::kPixels;
  constexpr double kFlat = kFlatContrast * kFlatContrast * kPixels;
  ColumnSums sums(image, box);
  const Window window(image, box);
  std::array<float, kWidest + kTogether> dot;
  std::optional<Match> best;
  for (int row = box.top; row <= box.bottom; ++row) {
    sums.enter(row);
    // A_xx x² + 2 A_xy x y + A_yy y² <= 1, solved for x
    const double y = row - centre.y(), middle = -A(0, 1) * y / A(0, 0);
    const double inside = middle * middle - (A(1, 1) * y * y - 1) / A(0, 0);
    const double half = inside < 0 ? -1 : std::sqrt(inside);
    const int first = std::max(box.left, static_cast<int>(std::ceil(centre.x() + middle - half)));
    const int last = std::min(box.right, static_cast<int>(std::floor(centre.x() + middle + half)));
    if (inside >= 0 && first <= last) {
      for (int column = first; column <= last; column += kTogether)
        window.products(patch, row - box.top, column - box.left, dot.data() + (column - first));
      std::int64_t sum = 0, square = 0;
      for (int i = first - box.left; i < first - box.left + 2 * kPatchHalf; ++i) {
        sum += sums.sum(static_cast<std::size_t>(i));
        square += sums.square(static_cast<std::size_t>(i));
      }
      for (int column = first; column <= last; ++column) {
        const auto right = static_cast<std::size_t>(column - box.left + 2 * kPatchHalf);
        sum += sums.sum(right);
        square += sums.square(right);
        const double spread = static_cast<double>(square) - static_cast<double>(sum * sum) / kPixels;
        const double correlation =
            spread > kFlat ? dot[static_cast<std::size_t>(column - first)] / std::sqrt(spread) : -1;
        if (spread > kFlat && (!best || correlation > best->correlation))
          best = Match{Eigen::Vector2d(column, row), correlation};
        const auto left = right - 2 * kPatchHalf;
        sum -= sums.sum(left);
        square -= sums.square(left);
      }
    }
    sums.leave(row);
  }
  return best;
}

}  // namespace slam
