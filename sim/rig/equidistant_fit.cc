#include "sim/rig/equidistant_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "slam/camera.h"

namespace sim::rig {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;  // fu, fv, k1 to k4
constexpr int kGrid = 40;                      // pixels a side for comparing the two cameras

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

}  // namespace sim::rig
