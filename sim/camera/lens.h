// The lens of the simulated head camera: turns the renderer's pinhole picture into the picture of a real
// lens.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "sim/camera/options.h"
#include "sim/rig/rig.h"

namespace sim::camera {

/// Returns the camera of the options: the wide camera of HRP-2's SLAM (320x240: f 197, 195; center 157, 127;
/// k1 7.37e-6 times the option's distortion; about 91.6° across), scaled to the image's size. Whole numbers
/// are pixel centers: the image covers [-0.5, width - 0.5].
slam::CameraIntrinsics camera_model(const CameraOptions& options);

/// Returns the direction (x/z, y/z; x right, y down, z forward) of a pixel of a camera_model() by the formula
/// of Swaminathan & Nayar as MonoSLAM uses it (Davison et al. 2007): u_d = u0 + u_c / sqrt(1 + 2 k1 |u_c|²),
/// u_c = (fu x/z, fv y/z). Needs 2 k1 |uv - u0|² < 1.
Eigen::Vector2d direction(const slam::CameraIntrinsics& camera, const Eigen::Vector2d& uv);

/// A pinhole picture with square pixels, or one of several side by side. Its frame is the
/// camera's, turned by `yaw` about y (down), positive to the right: column c, row r (from the top) look along
/// x/z = left + (c + 0.5) / focal_px, y/z = top + (r + 0.5) / focal_px of that frame.
struct Pinhole {
  int width_px, height_px;
  double focal_px;
  double left, top;                   ///< x/z and y/z at the picture's upper left edge
  double yaw = 0;                     ///< rad
  int first_column = 0;               ///< column of the whole picture at which this one starts
  std::vector<cv::Rect> unsampled{};  ///< parts of this picture that no pixel of the image samples
};

/// The minimum number of pinhole-picture pixels per image pixel, in any direction. The pictures are smoothed
/// before they are sampled, as a lens would do, so that finer detail does not alias.
inline constexpr double kSourceDensity = 1.2;

/// Warps the renderer's pinhole pictures through the camera's lens. A wide lens that compresses the outer
/// parts of its image is covered by two pinholes turned apart, each for half of the columns: a single one
/// would draw these parts with more pixels than are sampled.
class LensWarp {
 public:
  explicit LensWarp(const slam::CameraIntrinsics& camera);
  /// Returns one pinhole for the whole image, or one each for its left and right halves.
  const std::vector<Pinhole>& views() const { return views_; }
  /// Returns where pixel (u, v) samples the picture of the views side by side (pixel centers are whole).
  Eigen::Vector2d source_pixel(int u, int v) const;
  /// Returns the image of a picture of the views side by side, first row on top.
  cv::Mat warp(const cv::Mat& views) const;
  /// Returns depth along the camera's axis, mm (CV_16UC1, 0: none), from 1/z (1/m) along the axes of the
  /// views side by side. On a plane 1/z is linear in the pixel, so the sample's nearest pixel and its slopes
  /// give it exactly; next to an edge, the slope comes from the same side.
  cv::Mat1w depth_mm(const cv::Mat1f& inverse_depth) const;

 private:
  slam::CameraIntrinsics camera_;
  std::vector<Pinhole> views_;
  cv::Mat map_, fraction_;  ///< cv::remap's fixed-point maps
  cv::Mat3f samples_;  ///< for each pixel: source pixel (x, y), and depth divided by the depth in its view
};

}  // namespace sim::camera
