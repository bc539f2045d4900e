#include "slam/camera.h"

#include <cmath>
#include <stdexcept>

namespace slam {
namespace {

constexpr double kNearest = 1e-6;  // of |h|: what lies in or behind the image plane has no projection

}  // namespace

Camera::Camera(const CameraIntrinsics& intrinsics)
    : intrinsics_(intrinsics),
      focal_(intrinsics.fu_px, intrinsics.fv_px),
      centre_(intrinsics.u0_px, intrinsics.v0_px) {
  if (!(focal_.minCoeff() > 0) || intrinsics.width_px < 32 || intrinsics.height_px < 32)
    throw std::invalid_argument("camera: focal lengths must be positive and the image at least 32 px a side");
  if (!(intrinsics.k1_px2 >= 0)) throw std::invalid_argument("camera: k1_px2 must not be negative");
}

std::optional<Projection> Camera::project(const Eigen::Vector3d& h) const {
  if (!(h.z() > kNearest * h.norm())) return std::nullopt;
  const Eigen::Vector2d u = focal_.cwiseProduct(h.head<2>()) / h.z();
  const double f = 1 + 2 * intrinsics_.k1_px2 * u.squaredNorm();
  const double root = std::sqrt(f);
  Matrix23d du_dh;
  du_dh << focal_.x() / h.z(), 0, -u.x() / h.z(), 0, focal_.y() / h.z(), -u.y() / h.z();
  const Eigen::Matrix2d lens =
      Eigen::Matrix2d::Identity() / root - 2 * intrinsics_.k1_px2 / (f * root) * u * u.transpose();
  return Projection{centre_ + u / root, lens * du_dh};
}

std::optional<Ray> Camera::unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d d = pixel - centre_;
  const double g = 1 - 2 * intrinsics_.k1_px2 * d.squaredNorm();
  if (!(g > 1e-3)) return std::nullopt;
  const double root = std::sqrt(g);
  const Eigen::Matrix2d lens =
      Eigen::Matrix2d::Identity() / root + 2 * intrinsics_.k1_px2 / (g * root) * d * d.transpose();
  Ray ray{Eigen::Vector3d::Ones(), Matrix32d::Zero()};
  ray.h.head<2>() = (d / root).cwiseQuotient(focal_);
  ray.J.topRows<2>() = focal_.cwiseInverse().asDiagonal() * lens;
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
