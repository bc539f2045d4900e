#include "sim/camera/lens.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace sim::camera {
namespace {

constexpr int kMargin = 3;           // source px around a sample: bilinear, after smoothing
constexpr double kSmoothing = 0.55;  // source px: standard deviation that removes jagged edges

// Columns of the image that a view covers.
cv::Range columns_of(const slam::CameraIntrinsics& camera, int view) {
  return {camera.width_px * view / 2, camera.width_px * (view + 1) / 2};
}

// Direction (x/z, y/z) seen at a pixel, in axes turned by `yaw` about the camera's y.
Eigen::Vector2d turned_direction(const slam::CameraIntrinsics& camera, double yaw,
                                 const Eigen::Vector2d& uv) {
  const Eigen::Vector2d d = direction(camera, uv);
  const double z = std::cos(yaw) + std::sin(yaw) * d.x();
  return {(std::cos(yaw) * d.x() - std::sin(yaw)) / z, d.y() / z};
}

// The smallest distance between the directions of neighboring pixels in the columns: the smaller singular
// value of the direction's derivative, evaluated at pixels a few degrees apart.
double finest_step(const slam::CameraIntrinsics& camera, double yaw, const cv::Range& columns) {
  const int stride = std::max(1, camera.width_px / 64);
  double least = 1e9;
  for (int v = 0; v < camera.height_px; v += stride)
    for (int u = columns.start; u < columns.end; u += stride) {
      const auto at = [&](double du, double dv) { return turned_direction(camera, yaw, {u + du, v + dv}); };
      Eigen::Matrix2d J;
      J << at(0.5, 0) - at(-0.5, 0), at(0, 0.5) - at(0, -0.5);
      least = std::min(least, J.jacobiSvd().singularValues()[1]);
    }
  return least;
}

// The directions seen along the border of the columns. All others lie between them: the lens is monotonic.
Eigen::AlignedBox2d seen_directions(const slam::CameraIntrinsics& camera, double yaw,
                                    const cv::Range& columns) {
  Eigen::AlignedBox2d seen;
  const auto include = [&](int u, int v) {
    seen.extend(turned_direction(camera, yaw, Eigen::Vector2d(u, v)));
  };
  for (int u = columns.start; u < columns.end; ++u) include(u, 0), include(u, camera.height_px - 1);
  for (int v = 0; v < camera.height_px; ++v) include(columns.start, v), include(columns.end - 1, v);
  return seen;
}

// A pinhole aimed at the middle of the columns' field of view.
Pinhole covering(const slam::CameraIntrinsics& camera, const cv::Range& columns) {
  const auto yaw_of = [&](int u) { return std::atan(direction(camera, {double(u), camera.v0_px}).x()); };
  Pinhole view{};
  view.yaw = (yaw_of(columns.start) + yaw_of(columns.end - 1)) / 2;
  view.focal_px = kSourceDensity / finest_step(camera, view.yaw, columns);
  const Eigen::AlignedBox2d seen = seen_directions(camera, view.yaw, columns);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant((kMargin + 0.5) / view.focal_px);
  const Eigen::Vector2d low = seen.min() - margin, size_px = (seen.max() + margin - low) * view.focal_px;
  view.left = low.x(), view.top = low.y();
  view.width_px = int(std::ceil(size_px.x()));
  view.height_px = int(std::ceil(size_px.y()));
  return view;
}

// Strips along the sides of a view that no pixel samples: only the corners of the image reach far out.
std::vector<cv::Rect> unsampled_strips(const cv::Mat2f& map, const Pinhole& view) {
  constexpr int strips = 5;
  const int w = view.width_px, h = view.height_px;
  std::array<int, strips> left, right, top, bottom;
  left.fill(w), right.fill(0), top.fill(h), bottom.fill(0);
  for (const cv::Vec2f& sample : map) {
    const int x = int(sample[0]) - view.first_column, y = int(sample[1]);
    for (const int side : {-kMargin, kMargin}) {
      const int column = std::clamp(x + side, 0, w - 1) * strips / w,
                row = std::clamp(y + side, 0, h - 1) * strips / h;
      top[column] = std::min(top[column], y - kMargin),
      bottom[column] = std::max(bottom[column], y + kMargin);
      left[row] = std::min(left[row], x - kMargin), right[row] = std::max(right[row], x + kMargin);
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

// Returns the smaller of the slopes to both neighbors, or 0 if their signs differ: one neighbor may belong to
// another surface.
float slope(float before, float here, float after) {
  const float left = here - before, right = after - here;
  if (left * right <= 0) return 0;
  return std::abs(left) < std::abs(right) ? left : right;
}

}  // namespace

Eigen::Vector2d direction(const slam::CameraIntrinsics& camera, const Eigen::Vector2d& uv) {
  const Eigen::Vector2d d = uv - Eigen::Vector2d(camera.u0_px, camera.v0_px);
  const double k1_px2 = std::get<slam::OneParameterRadial>(camera.lens).k1_px2;
  const Eigen::Vector2d u_c = d / std::sqrt(1 - 2 * k1_px2 * d.squaredNorm());
  return {u_c.x() / camera.fu_px, u_c.y() / camera.fv_px};
}

slam::CameraIntrinsics camera_model(const CameraOptions& options) {
  const int w = options.width_px, h = options.height_px;
  if (options.fov_rad > 0) return rig::lens(w, h, options.fov_rad, options.distortion);
  const double s = w / 320.0;
  const slam::OneParameterRadial lens{7.37e-6 * options.distortion / (s * s)};
  return {w, h, 197 * s, 195 * s, (157 + 0.5) * s - 0.5, (127 + 0.5) * s - 0.5, lens};
}

LensWarp::LensWarp(const slam::CameraIntrinsics& camera) : camera_(camera) {
  for (const int half : {0, 1}) views_.push_back(covering(camera, columns_of(camera, half)));
  views_[1].first_column = views_[0].width_px;
  cv::Mat2f map(camera.height_px, camera.width_px);
  samples_.create(map.size());
  for (int v = 0; v < map.rows; ++v)
    for (int u = 0; u < map.cols; ++u) {
      const Eigen::Vector2d pixel = source_pixel(u, v);
      map(v, u) = cv::Vec2f(float(pixel.x()), float(pixel.y()));
      const double yaw = views_[u < columns_of(camera, 0).end ? 0 : 1].yaw;
      const double along = std::cos(yaw) + std::sin(yaw) * direction(camera, Eigen::Vector2d(u, v)).x();
      samples_(v, u) = cv::Vec3f(map(v, u)[0], map(v, u)[1], float(1 / along));
    }
  cv::convertMaps(map, cv::noArray(), map_, fraction_, CV_16SC2);
  for (const int half : {0, 1})
    views_[half].unsampled = unsampled_strips(map.colRange(columns_of(camera, half)), views_[half]);
}

Eigen::Vector2d LensWarp::source_pixel(int u, int v) const {
  const Pinhole& view = views_[u < columns_of(camera_, 0).end ? 0 : 1];
  const Eigen::Vector2d direction = turned_direction(camera_, view.yaw, Eigen::Vector2d(u, v));
  return (direction - Eigen::Vector2d(view.left, view.top)) * view.focal_px +
         Eigen::Vector2d(view.first_column - 0.5, -0.5);
}

cv::Mat LensWarp::warp(const cv::Mat& views) const {
  cv::Mat smooth, image;
  cv::GaussianBlur(views, smooth, {0, 0}, kSmoothing);
  cv::remap(smooth, image, map_, fraction_, cv::INTER_LINEAR);
  return image;
}

cv::Mat1w LensWarp::depth_mm(const cv::Mat1f& inverse_depth) const {
  cv::Mat1w image(samples_.size());
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const cv::Vec3f& sample = samples_(v, u);
      const int x = cvRound(sample[0]), y = cvRound(sample[1]);
      const float *above = inverse_depth.ptr<float>(y - 1), *row = inverse_depth.ptr<float>(y),
                  *below = inverse_depth.ptr<float>(y + 1);
      const float inverse = row[x] + (sample[0] - float(x)) * slope(row[x - 1], row[x], row[x + 1]) +
                            (sample[1] - float(y)) * slope(above[x], row[x], below[x]);
      image(v, u) = row[x] > 0 ? cv::saturate_cast<unsigned short>(1e3f * sample[2] / inverse) : 0;
    }
  return image;
}

}  // namespace sim::camera
