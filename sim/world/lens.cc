#include "sim/world/lens.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace sim::world {
namespace {

constexpr int kMargin = 3;           // px of the source around a sample: bilinear, after smoothing
constexpr double kSmoothing = 0.55;  // px of the source: standard deviation that removes the stairs of edges

struct Bounds {
  Eigen::Vector2d low, high;
};

// Directions seen along the image's border: those inside lie between, as the lens is monotonic along each
// ray.
Bounds seen_directions(const CameraModel& camera) {
  Bounds bounds{{0, 0}, {0, 0}};
  const auto include = [&](int u, int v) {
    const Eigen::Vector2d direction = camera.direction({u, v});
    bounds.low = bounds.low.cwiseMin(direction);
    bounds.high = bounds.high.cwiseMax(direction);
  };
  for (int u = 0; u < camera.width_px; ++u) include(u, 0), include(u, camera.height_px - 1);
  for (int v = 0; v < camera.height_px; ++v) include(0, v), include(camera.width_px - 1, v);
  return bounds;
}

Pinhole covering(const CameraModel& camera, double density) {
  const Bounds seen = seen_directions(camera);
  Pinhole source{};
  source.focal_px = density * std::max(camera.fu_px, camera.fv_px);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant((kMargin + 0.5) / source.focal_px);
  const Eigen::Vector2d low = seen.low - margin, size_px = (seen.high + margin - low) * source.focal_px;
  source.left = low.x(), source.top = low.y();
  source.width_px = static_cast<int>(std::ceil(size_px.x()));
  source.height_px = static_cast<int>(std::ceil(size_px.y()));
  return source;
}

// Strips along the four sides of the source that no pixel samples: the corners of the image reach far out,
// the middles of its sides do not.
std::vector<cv::Rect> unsampled_strips(const cv::Mat2f& bottom_up_map, const Pinhole& source) {
  constexpr int strips = 5;
  const int w = source.width_px, h = source.height_px;
  std::array<int, strips> left, right, top, bottom;
  left.fill(w), right.fill(0), top.fill(h), bottom.fill(0);
  for (const cv::Vec2f& sample : bottom_up_map) {
    const int x = int(sample[0]), y = h - 1 - int(sample[1]);
    for (int column : {x - kMargin, x + kMargin}) {
      const int strip = std::clamp(column, 0, w - 1) * strips / w;
      top[strip] = std::min(top[strip], y - kMargin), bottom[strip] = std::max(bottom[strip], y + kMargin);
    }
    for (int row : {y - kMargin, y + kMargin}) {
      const int strip = std::clamp(row, 0, h - 1) * strips / h;
      left[strip] = std::min(left[strip], x - kMargin), right[strip] = std::max(right[strip], x + kMargin);
    }
  }
  std::vector<cv::Rect> unsampled;
  for (int strip = 0; strip < strips; ++strip) {
    const cv::Range columns((strip * w + strips - 1) / strips, ((strip + 1) * w + strips - 1) / strips);
    const cv::Range rows((strip * h + strips - 1) / strips, ((strip + 1) * h + strips - 1) / strips);
    unsampled.push_back({columns.start, 0, columns.size(), top[strip]});
    unsampled.push_back({columns.start, bottom[strip] + 1, columns.size(), h - bottom[strip] - 1});
    unsampled.push_back({0, rows.start, left[strip], rows.size()});
    unsampled.push_back({right[strip] + 1, rows.start, w - right[strip] - 1, rows.size()});
  }
  std::erase_if(unsampled, [](const cv::Rect& strip) { return strip.width <= 0 || strip.height <= 0; });
  return unsampled;
}

}  // namespace

Eigen::Vector2d CameraModel::project(const Eigen::Vector3d& p_C) const {
  const Eigen::Vector2d u_c(fu_px * p_C.x() / p_C.z(), fv_px * p_C.y() / p_C.z());
  return Eigen::Vector2d(u0_px, v0_px) + u_c / std::sqrt(1 + 2 * k1_px2 * u_c.squaredNorm());
}

Eigen::Vector2d CameraModel::direction(const Eigen::Vector2d& uv) const {
  const Eigen::Vector2d d = uv - Eigen::Vector2d(u0_px, v0_px);
  const Eigen::Vector2d u_c = d / std::sqrt(1 - 2 * k1_px2 * d.squaredNorm());
  return {u_c.x() / fu_px, u_c.y() / fv_px};
}

CameraModel camera_model(const CameraOptions& options) {
  const int w = options.width_px, h = options.height_px;
  if (options.lens == Lens::pinhole) return {w, h, w / 2.0, w / 2.0, (w - 1) / 2.0, (h - 1) / 2.0, 0};
  const double s = w / 320.0;
  return {w, h, 197 * s, 195 * s, (157 + 0.5) * s - 0.5, (127 + 0.5) * s - 0.5, 7.37e-6 / (s * s)};
}

LensWarp::LensWarp(const CameraModel& camera, double density)
    : camera_(camera), density_(density), source_(covering(camera, density)) {
  cv::Mat2f map(camera.height_px, camera.width_px);
  for (int v = 0; v < map.rows; ++v)
    for (int u = 0; u < map.cols; ++u) {
      const Eigen::Vector2d pixel = source_pixel(u, v);
      map(v, u) = cv::Vec2f(float(pixel.x()), float(source_.height_px - 1 - pixel.y()));
    }
  cv::convertMaps(map, cv::noArray(), map_, fraction_, CV_16SC2);
  source_.unsampled = unsampled_strips(map, source_);
}

Eigen::Vector2d LensWarp::source_pixel(int u, int v) const {
  const Eigen::Vector2d edge(source_.left, source_.top);
  return ((camera_.direction({u, v}) - edge) * source_.focal_px).array() - 0.5;
}

cv::Mat LensWarp::warp(const cv::Mat& bottom_up) const {
  cv::Mat smooth = bottom_up, image;
  if (density_ > 1) cv::GaussianBlur(bottom_up, smooth, {0, 0}, kSmoothing);
  cv::remap(smooth, image, map_, fraction_, cv::INTER_LINEAR);
  return image;
}

}  // namespace sim::world
