// Whether the pictures show the room from where the camera truly was: corners of one picture, put on the
// room's surfaces by its true pose, are looked for in a later one where its true pose says.
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "sim/score/surfaces.h"
#include "slam/camera.h"
#include "slam/observation.h"

namespace sim::bench {

/// Uses the filter's camera model, which shares nothing with the renderer's lens. One pair of pictures a
/// second, 0.4 s apart: half a step, so that a picture that lags shows, the head swaying the other way.
class ViewCheck {
 public:
  ViewCheck(const slam::CameraIntrinsics& intrinsics, std::vector<score::Surface> surfaces);

  /// A picture and the true pose of its stamp.
  void take(const cv::Mat& image, slam::Stamp t, const Eigen::Isometry3d& X_WC);

  std::size_t points() const { return points_; }
  /// Median distance (px) between where points were found and where they should be; nothing for fewer than
  /// 30 points, as when the lights are off.
  std::optional<double> median_px() const;

 private:
  struct Corner {
    cv::Point pixel;
    Eigen::Vector3d p_W;
  };
  void remember(const cv::Mat& image, slam::Stamp t, const Eigen::Isometry3d& X_WC);
  void look(const cv::Mat& image, const Eigen::Isometry3d& X_WC);
  std::optional<Eigen::Vector2d> expected(const Eigen::Vector3d& p_W, const Eigen::Isometry3d& X_WC) const;

  slam::Camera camera_;
  std::vector<score::Surface> surfaces_;
  std::optional<slam::Stamp> remembered_at_;
  cv::Mat remembered_;
  std::vector<Corner> corners_;
  std::size_t points_ = 0;
  std::array<std::size_t, 200> distances_{};  // how many, by twentieths of a pixel
};

}  // namespace sim::bench
