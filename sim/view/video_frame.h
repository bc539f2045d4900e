// One picture of a video: the head image with the filter's searches, and the map from above.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "sim/files/trajectory_file.h"
#include "slam/filter.h"

namespace sim::view {

inline constexpr int kPanelWidth = 640, kPanelHeight = 480;  // px

/// The image at twice its size (or as near as the panel allows), with each search as its 3-sigma ellipse:
/// green with its 11 x 11 patch if the match was used, otherwise yellow; blue patches for new landmarks.
cv::Mat3b draw_view(const slam::Observation& seen, const slam::FrameReport& report);

/// From above, x of the world to the right, y up: the true path and 5 m around it.
class MapView {
 public:
  explicit MapView(const std::vector<files::TimedPose>& truth);
  /// Landmarks with their 2-sigma ellipses, the true path (grey), the estimated one (red) and the camera.
  cv::Mat3b draw(const slam::Estimate& estimate, const std::vector<slam::MapPoint>& map);

 private:
  cv::Point2d pixel(const Eigen::Vector3d& p_W) const;

  const std::vector<files::TimedPose>& truth_;
  Eigen::Vector2d center_;
  double px_per_m_;
  std::vector<cv::Point> walked_;
};

}  // namespace sim::view
