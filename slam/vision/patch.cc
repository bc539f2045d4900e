#include "slam/vision/patch.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace slam {
namespace {

constexpr double kObliqueCosine = 0.42;  // cos 65°
constexpr int kRefineIterations = 8;
constexpr double kConverged = 0.01;    // px
constexpr double kLargestShift = 1.5;  // px

using Gray = Eigen::Matrix<float, Template::kPixels, 1>;
constexpr int kTogether = 16;  // neighboring places computed at once
using Lane = Eigen::Array<float, kTogether, 1>;
using Places = Eigen::Array<double, kTogether, 1>;

/// Bilinear interpolation of a source patch at the first `count` of these columns u and rows v.
Lane sample(const SourcePatch& patch, const Places& u, const Places& v, int count) {
  const Places column = u.floor(), row = v.floor();
  const Lane a = (u - column).cast<float>(), b = (v - row).cast<float>();
  Lane g00 = Lane::Zero(), g10 = g00, g01 = g00, g11 = g00;
  const Eigen::Array<int, kTogether, 1> places = (row * kSourceSide + column).cast<int>();
  for (int i = 0; i < count; ++i) {
    const float* g = patch.gray.data() + places(i);
    g00(i) = g[0], g10(i) = g[1], g01(i) = g[kSourceSide], g11(i) = g[kSourceSide + 1];
  }
  return (1 - b) * ((1 - a) * g00 + a * g10) + b * ((1 - a) * g01 + a * g11);
}

/// The 11x11 gray values around a sub-pixel place inside the image, by bilinear interpolation.
Gray sample(const cv::Mat& image, const Eigen::Vector2d& center) {
  const double left = center.x() - kPatchHalf, top = center.y() - kPatchHalf;
  const int column = static_cast<int>(std::floor(left)), row = static_cast<int>(std::floor(top));
  const auto a = static_cast<float>(left - column), b = static_cast<float>(top - row);
  const float w00 = (1 - a) * (1 - b), w10 = a * (1 - b), w01 = (1 - a) * b, w11 = a * b;
  constexpr int kStride = kTogether + 1;
  std::array<float, kStride*(kPatchSide + 1)> around{};
  for (int j = 0; j <= kPatchSide; ++j)
    std::copy_n(image.ptr<uchar>(row + j) + column, kPatchSide + 1, around.data() + j * kStride);
  std::array<float, Template::kPixels + kTogether> gray;  // a row is computed with some places after it
  for (int j = 0; j < kPatchSide; ++j) {
    const auto at = [&](int place) { return Eigen::Map<const Lane>(around.data() + j * kStride + place); };
    Eigen::Map<Lane>(gray.data() + j * kPatchSide) =
        w00 * at(0) + w10 * at(1) + w01 * at(kStride) + w11 * at(kStride + 1);
  }
  return Eigen::Map<const Gray>(gray.data());
}

/// Normalizes to zero mean and unit norm. Returns false if the patch is flat.
bool normalize(Gray& gray, float* length = nullptr) {
  gray.array() -= gray.mean();
  const float norm = gray.norm();
  if (length != nullptr) *length = norm;
  if (norm < static_cast<float>(kFlatContrast * kPatchSide)) return false;
  gray /= norm;
  return true;
}

constexpr int kWidest = 2 * kLargestSearch + 1;

/// The range of pixels to search, ends included.
struct Box {
  int left, right, top, bottom;
};

Box search_box(const cv::Mat& image, const Eigen::Vector2d& center, const Eigen::Vector2d& half) {
  const Eigen::Vector2d reach = half.cwiseMin(kLargestSearch);
  return {std::max(kPatchHalf, static_cast<int>(std::ceil(center.x() - reach.x()))),
          std::min(image.cols - 1 - kPatchHalf, static_cast<int>(std::floor(center.x() + reach.x()))),
          std::max(kPatchHalf, static_cast<int>(std::ceil(center.y() - reach.y()))),
          std::min(image.rows - 1 - kPatchHalf, static_cast<int>(std::floor(center.y() + reach.y())))};
}

/// For each column around the box, the sum and sum of squares of 11 pixels, updated as the search moves down.
class ColumnSums {
 public:
  ColumnSums(const cv::Mat& image, const Box& box) : image_(image), left_(box.left - kPatchHalf) {
    columns_ = static_cast<std::size_t>(box.right - box.left + kPatchSide);
    for (int j = -kPatchHalf; j < kPatchHalf; ++j) add(box.top + j, 1);
  }
  /// sign: 1 for a row that enters, -1 for one that leaves.
  void add(int row, std::int32_t sign) {
    const uchar* gray = image_.ptr<uchar>(row) + left_;
    for (std::size_t i = 0; i < columns_; ++i) {
      const std::int32_t g = gray[i];
      sum[i] += sign * g;
      square[i] += sign * g * g;
    }
  }
  std::array<std::int32_t, kWidest + 2 * kPatchHalf> sum{}, square{};

 private:
  const cv::Mat& image_;
  int left_;
  std::size_t columns_;
};

/// The gray values that the templates in a box cover, padded so that a whole register can be read past them.
class Window {
 public:
  Window(const cv::Mat& image, const Box& box) {
    const int columns = box.right - box.left + kPatchSide, rows = box.bottom - box.top + kPatchSide;
    for (int j = 0; j < rows; ++j) {
      std::copy_n(image.ptr<uchar>(box.top - kPatchHalf + j) + box.left - kPatchHalf, columns, row(j));
      std::fill_n(row(j) + columns, kTogether, 0.0F);
    }
  }

  /// Correlates the template with the window at kTogether adjacent places, starting at (top, column) of the
  /// box.
  void products(const Template& patch, int top, int column, float* sums) const {
    Lane even = Lane::Zero(), odd = even;  // independent sums hide the latency of additions
    for (int j = 0; j < kPatchSide; ++j) {
      const float* t = patch.gray.data() + j * kPatchSide;
      const float* g = row(top + j) + column;
      for (int i = 0; i + 1 < kPatchSide; i += 2) {
        even += t[i] * Eigen::Map<const Lane>(g + i);
        odd += t[i + 1] * Eigen::Map<const Lane>(g + i + 1);
      }
      even += t[kPatchSide - 1] * Eigen::Map<const Lane>(g + kPatchSide - 1);
    }
    Eigen::Map<Lane>{sums} = even + odd;
  }

 private:
  static constexpr int kStride = kWidest + 2 * kPatchHalf + kTogether;
  float* row(int j) { return gray_.data() + j * kStride; }
  const float* row(int j) const { return gray_.data() + j * kStride; }

  std::array<float, static_cast<std::size_t>(kStride*(kWidest + 2 * kPatchHalf))> gray_;
};

}  // namespace

SourcePatch cut_patch(const cv::Mat& image, const Eigen::Vector2i& pixel) {
  SourcePatch patch;
  auto* out = patch.gray.data();
  for (int j = -kSourceHalf; j <= kSourceHalf; ++j)
    for (int i = -kSourceHalf; i <= kSourceHalf; ++i) *out++ = image.ptr<uchar>(pixel.y() + j)[pixel.x() + i];
  return patch;
}

SourcePatch cut_patch_between(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  SourcePatch patch;
  cv::Mat gray(kSourceSide, kSourceSide, CV_32F, patch.gray.data());
  cv::getRectSubPix(image, gray.size(), cv::Point2f(cv::Point2d(pixel.x(), pixel.y())), gray, CV_32F);
  return patch;
}

Eigen::Vector3d surface_normal(const Eigen::Isometry3d& X_WC_first, const Eigen::Vector3d& p_W,
                               const Eigen::Vector2d& tilt) {
  const Eigen::Vector3d facing = (X_WC_first.translation() - p_W).normalized();
  const Eigen::Vector3d turned = X_WC_first.linear().leftCols<2>() * tilt;
  return (facing + turned - facing.dot(turned) * facing).normalized();
}

std::optional<Eigen::Matrix2d> view_change(const Camera& camera, const Eigen::Isometry3d& X_WC_first,
                                           const Eigen::Isometry3d& X_WC_now, const Eigen::Vector3d& p_W,
                                           const Eigen::Vector3d& normal_W,
                                           const Eigen::Vector2d& pixel_now) {
  const auto ray = camera.unproject(pixel_now);
  if (!ray) return std::nullopt;
  const Eigen::Matrix3d& R_now = X_WC_now.linear();
  const Eigen::Vector3d line = R_now * ray->h, to_point = p_W - X_WC_now.translation();
  const double facing = normal_W.dot(line);
  if (!(-facing > kObliqueCosine * line.norm())) return std::nullopt;
  const Eigen::Matrix3d on_surface =
      normal_W.dot(to_point) / facing * (Eigen::Matrix3d::Identity() - line * normal_W.transpose() / facing);
  const auto first = camera.project(X_WC_first.inverse() * p_W);
  if (!first) return std::nullopt;
  return Eigen::Matrix2d(first->J * X_WC_first.linear().transpose() * on_surface * R_now * ray->J);
}

std::optional<Template> warp(const SourcePatch& patch, const Eigen::Matrix2d& A) {
  const double reach = (kPatchHalf + 1) * A.cwiseAbs().rowwise().sum().maxCoeff();
  if (!(reach < kSourceHalf) || !(A.determinant() > 0.1)) return std::nullopt;
  constexpr int kSide = kPatchSide + 2;  // with a border of one pixel for the gradient
  std::array<float, kSide * kSide + kTogether> wide;
  const Places x = Places::LinSpaced(0, kTogether - 1) - (kPatchHalf + 1);
  for (int j = 0; j < kSide; ++j) {
    const Eigen::Vector2d left = A.col(1) * (j - kPatchHalf - 1) + Eigen::Vector2d::Constant(kSourceHalf);
    Eigen::Map<Lane>(wide.data() + j * kSide) =
        sample(patch, A(0, 0) * x + left.x(), A(1, 0) * x + left.y(), kSide);
  }
  Template t;
  for (int j = 0; j < kPatchSide; ++j)
    for (int i = 0; i < kPatchSide; ++i) {
      const float* g = &wide[static_cast<std::size_t>((j + 1) * kSide + i + 1)];
      t.gray(j * kPatchSide + i) = g[0];
      t.gradient.row(j * kPatchSide + i) << (g[1] - g[-1]) / 2, (g[kSide] - g[-kSide]) / 2;
    }
  float length = 0;
  if (!normalize(t.gray, &length)) return std::nullopt;
  t.gradient /= length;
  t.gradient.rowwise() -= t.gradient.colwise().mean();
  return t;
}

std::optional<Match> refine(const cv::Mat& image, const Template& patch, const Eigen::Vector2d& start) {
  const double margin = kPatchHalf + 1;
  const auto along_gradient = [&](const Gray& gray) {
    return Eigen::Vector2f(patch.gradient.col(0).dot(gray), patch.gradient.col(1).dot(gray));
  };
  Eigen::Matrix2f information;
  information << along_gradient(patch.gradient.col(0)), along_gradient(patch.gradient.col(1));
  const Eigen::Matrix2f inverse = information.inverse();
  if (!inverse.allFinite()) return std::nullopt;
  Match match{start, 0};
  for (int k = 0; k < kRefineIterations; ++k) {
    if (match.pixel.x() < margin || match.pixel.y() < margin || match.pixel.x() > image.cols - 1 - margin ||
        match.pixel.y() > image.rows - 1 - margin)
      return std::nullopt;
    Gray gray = sample(image, match.pixel);
    if (!normalize(gray)) return std::nullopt;
    match.correlation = gray.dot(patch.gray);
    const Eigen::Vector2f step = inverse * along_gradient(patch.gray - gray);
    match.pixel += step.cast<double>();
    if (!((match.pixel - start).norm() < kLargestShift)) return std::nullopt;
    if (step.norm() < kConverged) break;
  }
  return match;
}

int searched_pixels(const Eigen::Matrix2d& S, double sigmas) {
  const Eigen::Vector2d reach = (sigmas * S.diagonal().cwiseSqrt()).cwiseMin(kLargestSearch);
  return (2 * static_cast<int>(reach.x()) + 1) * (2 * static_cast<int>(reach.y()) + 1);
}

std::optional<Match> search_ellipse(const cv::Mat& image, const Template& patch,
                                    const Eigen::Vector2d& center, const Eigen::Matrix2d& S, double sigmas) {
  const Box box = search_box(image, center, sigmas * S.diagonal().cwiseSqrt());
  if (box.left > box.right || box.top > box.bottom) return std::nullopt;
  const Eigen::Matrix2d A = S.inverse() / (sigmas * sigmas);
  constexpr double kPixels = Template::kPixels;
  constexpr double kFlat = kFlatContrast * kFlatContrast * kPixels;
  ColumnSums sums(image, box);
  const Window window(image, box);
  std::array<float, kWidest + kTogether> dot;
  std::optional<Match> best;
  for (int row = box.top; row <= box.bottom; ++row) {
    sums.add(row + kPatchHalf, 1);
    // A_xx x² + 2 A_xy x y + A_yy y² <= 1, solved for x
    const double y = row - center.y(), middle = -A(0, 1) * y / A(0, 0);
    const double inside = middle * middle - (A(1, 1) * y * y - 1) / A(0, 0);
    const double half = inside < 0 ? -1 : std::sqrt(inside);
    const int first = std::max(box.left, static_cast<int>(std::ceil(center.x() + middle - half)));
    const int last = std::min(box.right, static_cast<int>(std::floor(center.x() + middle + half)));
    if (inside >= 0 && first <= last) {
      for (int column = first; column <= last; column += kTogether)
        window.products(patch, row - box.top, column - box.left, dot.data() + (column - first));
      std::int64_t sum = 0, square = 0;
      for (int i = first - box.left; i < first - box.left + 2 * kPatchHalf; ++i) {
        sum += sums.sum[static_cast<std::size_t>(i)];
        square += sums.square[static_cast<std::size_t>(i)];
      }
      for (int column = first; column <= last; ++column) {
        const auto right = static_cast<std::size_t>(column - box.left + 2 * kPatchHalf);
        sum += sums.sum[right];
        square += sums.square[right];
        const double spread = static_cast<double>(square) - static_cast<double>(sum * sum) / kPixels;
        const double correlation =
            spread > kFlat ? dot[static_cast<std::size_t>(column - first)] / std::sqrt(spread) : -1;
        if (spread > kFlat && (!best || correlation > best->correlation))
          best = Match{Eigen::Vector2d(column, row), correlation};
        const auto left = right - 2 * kPatchHalf;
        sum -= sums.sum[left];
        square -= sums.square[left];
      }
    }
    sums.add(row - kPatchHalf, -1);
  }
  return best;
}

}  // namespace slam
