#include "slam/patch.h"

#include <Eigen/LU>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace slam {
namespace {

constexpr double kObliqueCosine = 0.42;  // cos 65°
constexpr int kRefineIterations = 8;
constexpr double kConverged = 0.01;    // px
constexpr double kLargestShift = 1.5;  // px

using Grey = Eigen::Matrix<float, Template::kPixels, 1>;

/// Bilinear interpolation of a source patch at an offset from its centre.
float sample(const SourcePatch& patch, double x, double y) {
  const double u = x + kSourceHalf, v = y + kSourceHalf;
  const int column = static_cast<int>(u), row = static_cast<int>(v);
  const auto a = static_cast<float>(u - column), b = static_cast<float>(v - row);
  const float* g = &patch.grey[static_cast<std::size_t>(row * kSourceSide + column)];
  return (1 - b) * ((1 - a) * g[0] + a * g[1]) + b * ((1 - a) * g[kSourceSide] + a * g[kSourceSide + 1]);
}

/// The 11x11 grey values around a sub-pixel place inside the image, by bilinear interpolation.
Grey sample(const cv::Mat& image, const Eigen::Vector2d& centre) {
  const double left = centre.x() - kPatchHalf, top = centre.y() - kPatchHalf;
  const int column = static_cast<int>(std::floor(left)), row = static_cast<int>(std::floor(top));
  const auto a = static_cast<float>(left - column), b = static_cast<float>(top - row);
  const float w00 = (1 - a) * (1 - b), w10 = a * (1 - b), w01 = (1 - a) * b, w11 = a * b;
  Grey grey;
  for (int j = 0; j < kPatchSide; ++j) {
    const uchar* up = image.ptr<uchar>(row + j) + column;
    const uchar* down = image.ptr<uchar>(row + j + 1) + column;
    for (int i = 0; i < kPatchSide; ++i)
      grey(j * kPatchSide + i) = w00 * up[i] + w10 * up[i + 1] + w01 * down[i] + w11 * down[i + 1];
  }
  return grey;
}

/// Normalises to zero mean and unit norm; false where the patch is flat.
bool normalise(Grey& grey, float* length = nullptr) {
  grey.array() -= grey.mean();
  const float norm = grey.norm();
  if (length != nullptr) *length = norm;
  if (norm < static_cast<float>(kFlatContrast * kPatchSide)) return false;
  grey /= norm;
  return true;
}

}  // namespace

SourcePatch cut_patch(const cv::Mat& image, const Eigen::Vector2i& pixel) {
  SourcePatch patch;
  auto* out = patch.grey.data();
  for (int j = -kSourceHalf; j <= kSourceHalf; ++j)
    for (int i = -kSourceHalf; i <= kSourceHalf; ++i) *out++ = image.ptr<uchar>(pixel.y() + j)[pixel.x() + i];
  return patch;
}

SourcePatch cut_patch_between(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  SourcePatch patch;
  cv::Mat grey(kSourceSide, kSourceSide, CV_32F, patch.grey.data());
  cv::getRectSubPix(image, grey.size(), cv::Point2f(cv::Point2d(pixel.x(), pixel.y())), grey, CV_32F);
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
  std::array<float, kSide * kSide> wide;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const Eigen::Vector2d offset = A * Eigen::Vector2d(i - kPatchHalf - 1, j - kPatchHalf - 1);
      wide[static_cast<std::size_t>(j * kSide + i)] = sample(patch, offset.x(), offset.y());
    }
  Template t;
  for (int j = 0; j < kPatchSide; ++j)
    for (int i = 0; i < kPatchSide; ++i) {
      const float* g = &wide[static_cast<std::size_t>((j + 1) * kSide + i + 1)];
      t.grey(j * kPatchSide + i) = g[0];
      t.gradient.row(j * kPatchSide + i) << (g[1] - g[-1]) / 2, (g[kSide] - g[-kSide]) / 2;
    }
  float length = 0;
  if (!normalise(t.grey, &length)) return std::nullopt;
  t.gradient /= length;
  t.gradient.rowwise() -= t.gradient.colwise().mean();
  return t;
}

std::optional<Match> refine(const cv::Mat& image, const Template& patch, const Eigen::Vector2d& start) {
  const double margin = kPatchHalf + 1;
  const Eigen::Matrix2f information = patch.gradient.transpose() * patch.gradient;
  const Eigen::Matrix2f inverse = information.inverse();
  if (!inverse.allFinite()) return std::nullopt;
  Match match{start, 0};
  for (int k = 0; k < kRefineIterations; ++k) {
    if (match.pixel.x() < margin || match.pixel.y() < margin || match.pixel.x() > image.cols - 1 - margin ||
        match.pixel.y() > image.rows - 1 - margin)
      return std::nullopt;
    Grey grey = sample(image, match.pixel);
    if (!normalise(grey)) return std::nullopt;
    match.correlation = grey.dot(patch.grey);
    const Eigen::Vector2f step = inverse * (patch.gradient.transpose() * (patch.grey - grey));
    match.pixel += step.cast<double>();
    if (!((match.pixel - start).norm() < kLargestShift)) return std::nullopt;
    if (step.norm() < kConverged) break;
  }
  return match;
}

}  // namespace slam
