// The camera's lens in words that other programs know: fitted by their equidistant model, or taken out of the
// images.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "slam/options.h"

namespace sim::stream {

/// A camera and how far it is from the one it stands for, px over the whole image.
struct FittedCamera {
  slam::CameraIntrinsics camera;
  double rms_px = 0, largest_px = 0;
};

/// The equidistant camera nearest to the given one: least squares over a grid of pixels, borders included, of
/// focal lengths and four coefficients; the principal point is kept.
FittedCamera fit_equidistant(const slam::CameraIntrinsics& camera);

/// Images as an ideal pinhole would have seen them.
class Undistorted {
 public:
  /// The pinhole (radial-tangential without distortion) has square pixels and the given camera's size and
  /// principal point; its focal length is the smallest whole number of px with which no pixel looks past the
  /// given image.
  explicit Undistorted(const slam::CameraIntrinsics& camera);
  const slam::CameraIntrinsics& pinhole() const { return pinhole_; }
  /// Bilinear; an image of the given camera's size.
  cv::Mat operator()(const cv::Mat& image) const;

 private:
  slam::CameraIntrinsics pinhole_;
  std::vector<Eigen::Vector2d> from_;  // where each pixel looks in the given image, row by row
};

}  // namespace sim::stream
