// Cameras and their images as exported: without lens distortion or with a lens that other programs know, and
// depth at the pixels of another camera.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "sim/rig/rig.h"
#include "slam/camera.h"

namespace sim::exports {

/// The coefficients of an exported camera's equidistant lens; nothing for a pinhole without distortion.
inline std::optional<std::array<double, 4>> equidistant_lens(const slam::CameraIntrinsics& camera) {
  const auto* k = std::get_if<slam::Equidistant>(&camera.lens);
  return k ? std::optional(std::array{k->k1, k->k2, k->k3, k->k4}) : std::nullopt;
}

/// Removes the lens distortion from images.
class Undistortion {
 public:
  /// The pinhole (radial-tangential without distortion) has square pixels and the given camera's size and
  /// principal point. Its focal length is the least whole number that keeps all its pixels inside.
  explicit Undistortion(const slam::CameraIntrinsics& camera);
  const slam::CameraIntrinsics& pinhole() const { return pinhole_; }
  /// Returns the pinhole's image by bilinear interpolation, of 16 bits by the nearest pixel. `image` has the
  /// given camera's size.
  cv::Mat operator()(const cv::Mat& image) const;

 private:
  slam::CameraIntrinsics pinhole_;
  std::vector<Eigen::Vector2d> from_;  // the place of each pixel in the given image, row by row
};

/// The exported form of a camera and its images.
struct ExportedCamera {
  /// undistort: as a pinhole, otherwise with the equidistant lens. One without distortion stays as it is.
  ExportedCamera(const slam::CameraIntrinsics& recorded, bool undistort);
  rig::FittedCamera fitted;
  std::optional<Undistortion> undistortion;
};

/// Renders the depth images (mm, 0: none) of one camera as another one would have them.
class DepthRegistration {
 public:
  /// X_to_from: from one camera to the other.
  DepthRegistration(const slam::CameraIntrinsics& from, const slam::CameraIntrinsics& to,
                    const Eigen::Isometry3d& X_to_from);
  /// Each pixel covers the projection of its square, and the nearest surface counts. Gaps of one pixel inside
  /// a surface are filled.
  cv::Mat1w operator()(const cv::Mat1w& depth_mm) const;

 private:
  struct Square {
    Eigen::Vector3d center, first, last;  // sight lines (z = 1) of a pixel and of two opposite corners
  };
  slam::Camera to_;
  cv::Size size_;
  Eigen::Isometry3d X_to_from_;
  std::vector<std::optional<Square>> squares_;  // of the given camera, row by row
};

/// Returns which part of the camera's image the other one also sees at a distance (m).
double overlap(const rig::RigSensor& camera, const rig::RigSensor& other, double distance_m);

}  // namespace sim::exports
