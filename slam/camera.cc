#include "slam/camera.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "slam/lens.h"

namespace slam {
namespace {

constexpr double kLeastForward = 1e-6;  // of h.z()/|h|; points in or behind the image plane are not projected
constexpr double kNarrowest_rad = 0.1;

}  // namespace

Camera::Camera(const CameraIntrinsics& intrinsics)
    : intrinsics_(intrinsics),
      focal_(intrinsics.fu_px, intrinsics.fv_px),
      centre_(intrinsics.u0_px, intrinsics.v0_px),
      widest_(std::numeric_limits<double>::infinity()) {
  if (!(focal_.minCoeff() > 0) || intrinsics.width_px < 32 || intrinsics.height_px < 32)
    throw std::invalid_argument("camera: focal lengths must be positive and the image at least 32 px a side");
  if (const auto* radial = std::get_if<OneParameterRadial>(&intrinsics.lens)) {
    if (!(radial->k1_px2 >= 0)) throw std::invalid_argument("camera: k1_px2 must not be negative");
  } else {
    widest_ = std::tan(widest_angle(intrinsics.lens));
    if (!(widest_ > std::tan(kNarrowest_rad)))
      throw std::invalid_argument("camera: its distortion coefficients make no lens");
  }
}

std::optional<Projection> Camera::project(const Eigen::Vector3d& h) const {
  if (!(h.z() > kLeastForward * h.norm())) return std::nullopt;
  if (!(h.head<2>().norm() <= widest_ * h.z())) return std::nullopt;
  const Eigen::Vector2d u = focal_.cwiseProduct(h.head<2>()) / h.z();
  Matrix23d du_dh;
  du_dh << focal_.x() / h.z(), 0, -u.x() / h.z(), 0, focal_.y() / h.z(), -u.y() / h.z();
  const Distorted distorted = distort(intrinsics_.lens, focal_, u);
  return Projection{centre_ + distorted.point, distorted.J * du_dh};
}

std::optional<Ray> Camera::unproject(const Eigen::Vector2d& pixel) const {
  const auto undistorted = undistort(intrinsics_.lens, focal_, pixel - centre_);
  if (!undistorted) return std::nullopt;
  Ray ray{Eigen::Vector3d::Ones(), Matrix32d::Zero()};
  ray.h.head<2>() = undistorted->point.cwiseQuotient(focal_);
  if (!(ray.h.head<2>().norm() <= widest_)) return std::nullopt;
  ray.J.topRows<2>() = focal_.cwiseInverse().asDiagonal() * undistorted->J;
  return ray;
}

bool Camera::inside(const Eigen::Vector2d& pixel, double margin_px) const {
  return pixel.x() >= margin_px && pixel.y() >= margin_px &&
         pixel.x() <= intrinsics_.width_px - 1 - margin_px &&
         pixel.y() <= intrinsics_.height_px - 1 - margin_px;
}

double Camera::sigma(const Eigen::Vector2d& pixel, double sigma_px) const {
  return sigma_px * (1 + (pixel - centre_).norm() / centre_.norm());
}

}  // namespace slam
