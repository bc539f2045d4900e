// The filter's camera: one-parameter radial lens, projection and its inverse, each with its Jacobian.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "slam/options.h"

namespace slam {

using Matrix23d = Eigen::Matrix<double, 2, 3>;
using Matrix32d = Eigen::Matrix<double, 3, 2>;

/// Where a point of the camera's axes lands: pixel (u, v) and ∂pixel/∂h.
struct Projection {
  Eigen::Vector2d pixel;
  Matrix23d J;
};

/// The line of sight of a pixel: h = (x, y, 1) in the camera's axes and ∂h/∂pixel.
struct Ray {
  Eigen::Vector3d h;
  Matrix32d J;
};

/// Radial model of Swaminathan & Nayar as MonoSLAM uses it: u_d = u_0 + u_c/√(1 + 2K₁|u_c|²), z forward, u
/// right, v down.
class Camera {
 public:
  /// Throws std::invalid_argument where focal lengths or size are not positive or k1_px2 is negative.
  explicit Camera(const CameraIntrinsics& intrinsics);

  /// h in m (or any positive multiple) in the camera's axes; nothing where the point is not in front.
  std::optional<Projection> project(const Eigen::Vector3d& h) const;
  /// Exact inverse of project; nothing outside the lens' image circle 2K₁|d|² < 1.
  std::optional<Ray> unproject(const Eigen::Vector2d& pixel) const;

  /// At least margin_px inside the image on every side.
  bool inside(const Eigen::Vector2d& pixel, double margin_px) const;
  /// Measurement standard deviation (px): sigma_px at the centre, growing linearly to twice that at the
  /// corner.
  double sigma(const Eigen::Vector2d& pixel, double sigma_px) const;

  const CameraIntrinsics& intrinsics() const { return intrinsics_; }

 private:
  CameraIntrinsics intrinsics_;
  Eigen::Vector2d focal_, centre_;
};

}  // namespace slam
