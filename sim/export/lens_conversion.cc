#include "sim/export/lens_conversion.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "slam/camera.h"

namespace sim::exports {
namespace {

constexpr int kGrid = 40;                      // pixels a side for comparing the two cameras
using Vector6d = Eigen::Matrix<double, 6, 1>;  // fu, fv, k1 to k4

// A pixel and the line of sight (x, y, 1) of the given camera there.
struct Sightline {
  Eigen::Vector2d pixel, n;
};

// One Gauss-Newton step: the pixel is (u0, v0) + (fu x, fv y)/r (θ + k1 θ³ + ...), linear in each parameter.
Vector6d step(const std::vector<Sightline>& sights, const slam::CameraIntrinsics& camera, const Vector6d& p) {
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6d b = Vector6d::Zero();
  for (const Sightline& sight : sights) {
    const double r = sight.n.norm();
    if (r < 1e-9) continue;
    const double angle = std::atan(r), a2 = angle * angle;
    const Eigen::Vector4d powers = angle * Eigen::Vector4d(a2, a2 * a2, a2 * a2 * a2, a2 * a2 * a2 * a2);
    const double bent = angle + powers.dot(p.tail<4>());
    for (int axis = 0; axis < 2; ++axis) {
      const double along = sight.n(axis) / r;
      Vector6d J = Vector6d::Zero();
      J(axis) = along * bent;
      J.tail<4>() = p(axis) * along * powers;
      const double center = axis == 0 ? camera.u0_px : camera.v0_px;
      A += J * J.transpose();
      b += J * (sight.pixel(axis) - center - p(axis) * along * bent);
    }
  }
  return A.ldlt().solve(b);
}

// Returns whether every pixel of the pinhole lies inside the recorded image.
bool inside_recorded(const slam::Camera& recorded, const slam::CameraIntrinsics& pinhole) {
  const auto is_inside = [&](int column, int row) {
    const auto at = recorded.project(
        {(column - pinhole.u0_px) / pinhole.fu_px, (row - pinhole.v0_px) / pinhole.fv_px, 1});
    return at && recorded.inside(at->pixel, 0);
  };
  const int right = pinhole.width_px - 1, bottom = pinhole.height_px - 1;
  for (int column = 0; column <= right; ++column)
    if (!is_inside(column, 0) || !is_inside(column, bottom)) return false;
  for (int row = 0; row <= bottom; ++row)
    if (!is_inside(0, row) || !is_inside(right, row)) return false;
  return true;
}

// `at` lies inside the image.
unsigned char bilinear(const cv::Mat& image, const Eigen::Vector2d& at) {
  const int left = std::min(static_cast<int>(at.x()), image.cols - 2),
            top = std::min(static_cast<int>(at.y()), image.rows - 2);
  const double a = at.x() - left, b = at.y() - top;
  const unsigned char *upper = image.ptr(top) + left, *lower = image.ptr(top + 1) + left;
  const double grey = (1 - b) * ((1 - a) * upper[0] + a * upper[1]) + b * ((1 - a) * lower[0] + a * lower[1]);
  return static_cast<unsigned char>(std::lround(grey));
}

}  // namespace

FittedCamera fit_equidistant(const slam::CameraIntrinsics& camera) {
  const slam::Camera original(camera);
  std::vector<Sightline> grid;
  for (int row = 0; row < kGrid; ++row)
    for (int column = 0; column < kGrid; ++column) {
      const Eigen::Vector2d pixel((camera.width_px - 1.0) * column / (kGrid - 1),
                                  (camera.height_px - 1.0) * row / (kGrid - 1));
      if (const auto ray = original.unproject(pixel)) grid.push_back({pixel, ray->h.head<2>()});
    }
  Vector6d p;
  p << camera.fu_px, camera.fv_px, 0, 0, 0, 0;
  for (int i = 0; i < 20; ++i) p += step(grid, camera, p);
  FittedCamera fitted{camera};
  fitted.camera.fu_px = p(0), fitted.camera.fv_px = p(1);
  fitted.camera.lens = slam::Equidistant{p(2), p(3), p(4), p(5)};
  const slam::Camera equidistant(fitted.camera);
  for (const Sightline& sight : grid) {
    const auto at = equidistant.project(sight.n.homogeneous());
    if (!at) throw std::logic_error("the fitted lens covers less than the original one");
    const double off = (at->pixel - sight.pixel).norm();
    fitted.rms_px += off * off / static_cast<double>(grid.size());
    fitted.largest_px = std::max(fitted.largest_px, off);
  }
  fitted.rms_px = std::sqrt(fitted.rms_px);
  return fitted;
}

Undistortion::Undistortion(const slam::CameraIntrinsics& camera) : pinhole_(camera) {
  const slam::Camera recorded(camera);
  pinhole_.lens = slam::RadialTangential{};
  for (pinhole_.fu_px = pinhole_.fv_px = 1; !inside_recorded(recorded, pinhole_);
       pinhole_.fv_px = ++pinhole_.fu_px)
    if (pinhole_.fu_px > 1e5) throw std::logic_error("no pinhole looks through this lens");
  const slam::Camera straight(pinhole_);
  for (int row = 0; row < camera.height_px; ++row)
    for (int column = 0; column < camera.width_px; ++column)
      from_.push_back(recorded.project(straight.unproject({column, row})->h)->pixel);
}

cv::Mat Undistortion::operator()(const cv::Mat& image) const {
  cv::Mat straight(image.rows, image.cols, CV_8UC1);
  auto from = from_.begin();
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.cols; ++column)
      straight.at<unsigned char>(row, column) = bilinear(image, *from++);
  return straight;
}

}  // namespace sim::exports
