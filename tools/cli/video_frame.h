// One picture of a video: what the head camera saw with what the filter looked for in it, and its map from
// above.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "sim/files/trajectory_file.h"
#include "slam/filter.h"

namespace cli {

inline constexpr int kPanelWidth = 640, kPanelHeight = 480;  // px

/// The image twice its size (or as near as the panel allows), with each search as its 3-sigma ellipse: green
/// and with its 11 x 11 patch where the match was used, yellow where nothing was found or it was not
/// believed; blue patches where landmarks were begun.
cv::Mat3b draw_view(const slam::Observation& seen, const slam::FrameReport& report);

/// From above: x of the world to the right, y up; the true path and what lies within 5 m of it.
class MapView {
 public:
  explicit MapView(const std::vector<sim::files::TimedPose>& truth);
  /// Landmarks with their 2-sigma ellipses, the true path (grey), the estimated one (red) and the camera.
  cv::Mat3b draw(const slam::Estimate& estimate, const std::vector<slam::MapPoint>& map);

 private:
  cv::Point2d pixel(const Eigen::Vector3d& p_W) const;

  const std::vector<sim::files::TimedPose>& truth_;
  Eigen::Vector2d centre_;
  double px_per_m_;
  std::vector<cv::Point> walked_;
};

}  // namespace cli
