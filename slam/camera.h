// The filter's camera: projection through its lens and the inverse, each with its Jacobian.
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

/// A pinhole behind one of the lenses of options.h: z forward, u right, v down.
class Camera {
 public:
  /// Throws std::invalid_argument where focal lengths or size are not positive or the lens is none: k1_px2
  /// negative, a coefficient not finite, or usable to less than 0.1 rad from the axis.
  explicit Camera(const CameraIntrinsics& intrinsics);

  /// h in m (or any positive multiple) in the camera's axes; nothing where the point is not in front,
  /// or so far aside that the lens says nothing of it.
  std::optional<Projection> project(const Eigen::Vector3d& h) const;
  /// Exact inverse of project; nothing outside the lens' image circle.
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
  double widest_;  // |(x/z, y/z)| up to which the lens says something
};

}  // namespace slam
