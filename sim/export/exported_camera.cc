#include "sim/export/exported_camera.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sim::exports {
namespace {

// Writes a pixel of 8 bits a channel; `at` lies inside the image.
void bilinear(const cv::Mat& image, const Eigen::Vector2d& at, unsigned char* pixel) {
  const int left = std::min(static_cast<int>(at.x()), image.cols - 2),
            top = std::min(static_cast<int>(at.y()), image.rows - 2), n = image.channels();
  const double a = at.x() - left, b = at.y() - top;
  const unsigned char *upper = image.ptr(top, left), *lower = image.ptr(top + 1, left);
  for (int i = 0; i < n; ++i)
    pixel[i] = static_cast<unsigned char>(std::lround((1 - b) * ((1 - a) * upper[i] + a * upper[n + i]) +
                                                      b * ((1 - a) * lower[i] + a * lower[n + i])));
}

bool is_pinhole(const slam::CameraIntrinsics& camera) {
  const auto* lens = std::get_if<slam::OneParameterRadial>(&camera.lens);
  return lens && lens->k1_px2 == 0;
}

/// Depths that one surface may have at both sides of a pixel.
bool is_same_surface(int a_mm, int b_mm) {
  return a_mm > 0 && b_mm > 0 && std::abs(a_mm - b_mm) < 0.05 * std::min(a_mm, b_mm);
}

cv::Mat1w filled(const cv::Mat1w& depth_mm) {
  cv::Mat1w full = depth_mm.clone();
  for (int v = 0; v < depth_mm.rows; ++v)
    for (int u = 0; u < depth_mm.cols; ++u)
      for (const cv::Point step : {cv::Point(1, 0), cv::Point(0, 1)}) {
        const cv::Point before = cv::Point(u, v) - step, after = cv::Point(u, v) + step;
        if (full(v, u) > 0 || before.x < 0 || before.y < 0 || after.x >= full.cols || after.y >= full.rows)
          continue;
        const int a = depth_mm(before), b = depth_mm(after);
        if (is_same_surface(a, b)) full(v, u) = static_cast<std::uint16_t>((a + b) / 2);
      }
  return full;
}

}  // namespace

Undistortion::Undistortion(const slam::CameraIntrinsics& camera) : pinhole_(camera) {
  const slam::Camera recorded(camera);
  const int pixels = camera.width_px * camera.height_px;
  pinhole_.lens = slam::RadialTangential{};
  pinhole_.fu_px = 0;
  while (from_.size() < static_cast<std::size_t>(pixels)) {
    pinhole_.fv_px = ++pinhole_.fu_px;
    if (pinhole_.fu_px > 1e5) throw std::logic_error("no pinhole looks through this lens");
    from_.clear();
    for (int i = 0; i < pixels; ++i) {
      const auto at = recorded.project({(i % camera.width_px - pinhole_.u0_px) / pinhole_.fu_px,
                                        (i / camera.width_px - pinhole_.v0_px) / pinhole_.fv_px, 1});
      if (!at || !recorded.inside(at->pixel, 0)) break;
      from_.push_back(at->pixel);
    }
  }
}

cv::Mat Undistortion::operator()(const cv::Mat& image) const {
  cv::Mat straight(image.rows, image.cols, image.type());
  auto from = from_.begin();
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.cols; ++column, ++from)
      if (image.depth() == CV_16U)
        straight.at<std::uint16_t>(row, column) = image.at<std::uint16_t>(
            static_cast<int>(std::lround(from->y())), static_cast<int>(std::lround(from->x())));
      else
        bilinear(image, *from, straight.ptr(row, column));
  return straight;
}

ExportedCamera::ExportedCamera(const slam::CameraIntrinsics& recorded, bool undistort) : fitted{recorded} {
  if (is_pinhole(recorded)) {
    fitted.camera.lens = slam::RadialTangential{};
  } else if (undistort) {
    undistortion.emplace(recorded);
    fitted.camera = undistortion->pinhole();
  } else {
    fitted = rig::fit_equidistant(recorded);
  }
}

DepthRegistration::DepthRegistration(const slam::CameraIntrinsics& from, const slam::CameraIntrinsics& to,
                                     const Eigen::Isometry3d& X_to_from)
    : to_(to), size_(to.width_px, to.height_px), X_to_from_(X_to_from) {
  const slam::Camera camera(from);
  for (int v = 0; v < from.height_px; ++v)
    for (int u = 0; u < from.width_px; ++u) {
      const auto center = camera.unproject({u, v}), first = camera.unproject({u - 0.5, v - 0.5}),
                 last = camera.unproject({u + 0.5, v + 0.5});
      squares_.emplace_back();
      if (center && first && last) squares_.back() = {center->h, first->h, last->h};
    }
}

cv::Mat1w DepthRegistration::operator()(const cv::Mat1w& depth_mm) const {
  cv::Mat1w nearest(size_, 0);
  auto square = squares_.begin();
  for (const std::uint16_t mm : depth_mm) {
    const auto& sight = *square++;
    if (mm == 0 || !sight) continue;
    const auto moved = [&](const Eigen::Vector3d& line) { return X_to_from_ * (1e-3 * mm * line); };
    const auto first = to_.project(moved(sight->first)), last = to_.project(moved(sight->last));
    const double z_mm = std::round(1e3 * moved(sight->center).z());
    if (!first || !last || z_mm < 1 || z_mm > 65535) continue;
    const auto range = [](double from, double to, int size) {
      return cv::Range(static_cast<int>(std::clamp<double>(std::ceil(from), 0, size)),
                       static_cast<int>(std::clamp<double>(std::ceil(to), 0, size)));
    };
    const cv::Range rows = range(first->pixel.y(), last->pixel.y(), size_.height),
                    columns = range(first->pixel.x(), last->pixel.x(), size_.width);
    for (int v = rows.start; v < rows.end; ++v)
      for (int u = columns.start; u < columns.end; ++u)
        if (nearest(v, u) == 0 || z_mm < nearest(v, u)) nearest(v, u) = static_cast<std::uint16_t>(z_mm);
  }
  return filled(nearest);
}

double overlap(const rig::RigSensor& camera, const rig::RigSensor& other, double distance_m) {
  constexpr int kGrid = 20;
  const slam::Camera from(camera.camera), to(other.camera);
  int seen = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const Eigen::Vector2d pixel((i % kGrid + 0.5) / kGrid * camera.camera.width_px - 0.5,
                                (i / kGrid + 0.5) / kGrid * camera.camera.height_px - 0.5);
    const auto ray = from.unproject(pixel);
    if (!ray) continue;
    const auto at = to.project(other.X_CS.inverse() * camera.X_CS * (distance_m * ray->h));
    seen += at && to.inside(at->pixel, 0);
  }
  return double(seen) / (kGrid * kGrid);
}

}  // namespace sim::exports
