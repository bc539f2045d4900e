// The camera model of the filter: projection through the lens and its inverse, with Jacobians.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "slam/options.h"

namespace slam {

using Matrix23d = Eigen::Matrix<double, 2, 3>;
using Matrix32d = Eigen::Matrix<double, 3, 2>;

/// The projection of a vector h in C: pixel (u, v) and ∂pixel/∂h.
struct Projection {
  Eigen::Vector2d pixel;
  Matrix23d J;
};

/// The ray of a pixel: h = (x, y, 1) in C and ∂h/∂pixel.
struct Ray {
  Eigen::Vector3d h;
  Matrix32d J;
};

/// A pinhole camera with one of the lenses of options.h; z forward, u right, v down.
class Camera {
 public:
  /// Throws std::invalid_argument if a focal length (px) is at most 1/16 of the width, the image is smaller
  /// than 32 px, k1_px2 is negative, a coefficient is not finite, or the lens model is valid for less than
  /// 0.1 rad from its axis.
  explicit Camera(const CameraIntrinsics& intrinsics);
  /// Projects h, which may have any positive length. Returns nothing if h does not point forward or lies
  /// outside the valid field of view of the lens model.
  std::optional<Projection> project(const Eigen::Vector3d& h) const;
  /// The exact inverse of project(). Returns nothing outside the image circle of the lens.
  std::optional<Ray> unproject(const Eigen::Vector2d& pixel) const;
  /// The displacement of a pixel by the lens, relative to a pinhole camera, px.
  Eigen::Vector2d displacement(const Eigen::Vector3d& h, const Eigen::Vector2d& pixel) const {
    return pixel - center_ - focal_.cwiseProduct(h.head<2>()) / h.z();
  }
  /// True if the pixel lies at least margin_px inside the image on every side.
  bool inside(const Eigen::Vector2d& pixel, double margin_px) const;
  /// Standard deviation of a measured pixel, px: sigma_px at the center, growing linearly to 2 sigma_px at
  /// the corner.
  double sigma(const Eigen::Vector2d& pixel, double sigma_px) const;

  const CameraIntrinsics& intrinsics() const { return intrinsics_; }

 private:
  CameraIntrinsics intrinsics_;
  Eigen::Vector2d focal_, center_;
  double widest_;  // largest valid |(x/z, y/z)| of the lens model
};

}  // namespace slam
