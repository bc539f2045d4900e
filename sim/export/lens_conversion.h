// The camera's lens for programs without its model: fitted by the equidistant model, or removed from the
// images.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "slam/options.h"

namespace sim::exports {

/// A camera that approximates another one; the distance of their pixels over the whole image.
struct FittedCamera {
  slam::CameraIntrinsics camera;
  double rms_px = 0, largest_px = 0;
};

/// The equidistant camera nearest to the given one: least squares in the two focal lengths and four
/// coefficients over a grid of pixels that includes the borders. The principal point is kept.
FittedCamera fit_equidistant(const slam::CameraIntrinsics& camera);

/// Removes the lens distortion from images.
class Undistortion {
 public:
  /// The pinhole (radial-tangential without distortion) has square pixels and the given camera's size and
  /// principal point. Its focal length is the smallest whole number of px that keeps all its pixels
  /// inside the given image.
  explicit Undistortion(const slam::CameraIntrinsics& camera);
  const slam::CameraIntrinsics& pinhole() const { return pinhole_; }
  /// The pinhole's image by bilinear interpolation; `image` has the given camera's size.
  cv::Mat operator()(const cv::Mat& image) const;

 private:
  slam::CameraIntrinsics pinhole_;
  std::vector<Eigen::Vector2d> from_;  // the place of each pixel in the given image, row by row
};

}  // namespace sim::exports
