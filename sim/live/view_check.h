// The self check of images: corners of one image, put on the room's surfaces by its true pose, must be found
// in a later one where its true pose puts them.
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "sim/score/surfaces.h"
#include "slam/camera.h"
#include "slam/observation.h"

namespace sim::live {

/// Uses the filter's camera model, which shares nothing with the renderer's lens. One pair of images a
/// second, 0.4 s apart: half a step, when the head sways the other way, so that an image that lags
/// shows.
class ViewCheck {
 public:
  ViewCheck(const slam::CameraIntrinsics& intrinsics, std::vector<score::Surface> surfaces);

  /// An image and the true pose at its stamp.
  void add(const cv::Mat& image, slam::Stamp t, const Eigen::Isometry3d& X_WC);

  std::size_t points() const { return points_; }
  /// Median distance (px) of found points from their projections; nullopt for fewer than
  /// 30 points, as when the lights are off.
  std::optional<double> median_px() const;

 private:
  struct Corner {
    cv::Point pixel;
    Eigen::Vector3d p_W;
  };
  void extract_corners(const cv::Mat& image, slam::Stamp t, const Eigen::Isometry3d& X_WC);
  void find_corners(const cv::Mat& image, const Eigen::Isometry3d& X_WC);
  std::optional<Eigen::Vector2d> expected(const Eigen::Vector3d& p_W, const Eigen::Isometry3d& X_WC) const;

  slam::Camera camera_;
  std::vector<score::Surface> surfaces_;
  std::optional<slam::Stamp> first_t_;
  cv::Mat first_;
  std::vector<Corner> corners_;
  std::size_t points_ = 0;
  std::array<std::size_t, 200> distances_{};  // how many, by twentieths of a pixel
};

}  // namespace sim::live
