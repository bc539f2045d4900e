// The visual part of a step (Stasse et al. 2006, section III-A): it measures landmarks in an image, manages
// the map, and recovers the pose after a loss.
#pragma once

#include "slam/monitors.h"
#include "slam/vision/map.h"
#include "slam/vision/relocalization.h"
#include "slam/vision/vision.h"

namespace slam {

/// One image, its circumstances, and the filter that it updates.
struct VisualInput {
  const cv::Mat& image;
  DepthImage depth;
  Stamp t, interval;  ///< interval: since the previous accepted observation; 0 at the first
  bool stands_still;  ///< the camera is known to stand still
  bool has_plan;      ///< or leg odometry
  int frame;          ///< number of estimates so far
  Kalman& kalman;
  TrackingMonitor& tracking;
  FrameReport& report;  ///< already contains the height's innovation; the visual part is added
};

/// Results of the visual part of one step for the sensor monitors.
struct VisualResult {
  bool good_image = false;  ///< not missing, flat or frozen, and without a gap before it
  std::optional<TrackingStatistics> statistics;
  std::size_t deleted_young = 0;  ///< unreliable landmarks that were deleted soon after their first sight
};

/// The pose part of the state; its covariance is symmetric to the last bit.
Estimate pose_estimate(const State& state, Stamp t);
/// True if the pose is certain enough to predict pixels with (0.05 rad and 0.1 m).
bool knows_pose(const Estimate& pose);

class VisualTracking {
 public:
  VisualTracking(const Options& options, const Camera& camera, std::uint64_t seed);

  const CameraIntrinsics& intrinsics() const { return camera_.intrinsics(); }
  std::vector<MapPoint> map(const State& state) const { return map_.points(state); }
  const std::vector<Landmark>& landmarks() const { return map_.landmarks(); }
  MapUse map_use() const { return loaded_.use; }
  SavedMap saved_map(const State& state) const { return map_.saved(state); }
  /// Loads a map, whose landmarks are searched for in the whole image until a pose is accepted. See MapStart.
  void start_from(const SavedMap& map, MapStart start, Kalman& kalman);
  /// Predicts the match biases over the frame interval that ends at t. In a known place, the map is
  /// considered.
  void predict(Stamp t, double dt_s, Kalman& kalman) {
    vision_.biases().predict(dt_s, kalman);
    if (map_use() != MapUse::searching) map_.consider_known(t, kalman);
  }
  /// Measures the landmarks in the image, updates the state and manages the map; relocalizes a lost filter.
  /// Reports to `tracking` whether landmarks were seen. Does nothing if vision is disabled.
  VisualResult step(const VisualInput& input);

 private:
  void blind(const VisualInput& input, const std::string& why);
  void track(const VisualInput& input);
  std::optional<std::string> measure(const VisualInput& input,
                                     const std::optional<RobotState>& uncertain = {});
  bool try_new_landmarks(const VisualInput& input);
  void record_searches(const VisualInput& input, bool counts);
  void refine_landmarks(const VisualInput& input, const VisionResult& vision);
  InitializationCount manage_map(const VisualInput& input, const VisionResult& vision, bool may_initialize);
  void report_initialized(std::size_t first, FrameReport& report);
  void relocalize(const VisualInput& input);
  bool confirms(const VisualInput& input, const Estimate& found, const Estimate& predicted);
  bool is_ambiguous(const VisualInput& input, const Estimate& found) const;
  void refuse_if_not_recognized(const VisualInput& input);
  void recovered(const VisualInput& input);

  bool enabled_;
  double sigma_px_, lost_after_s_;
  Camera camera_;
  ImageCheck image_check_;
  Vision vision_;
  Map map_;
  struct {
    MapUse use = MapUse::none;
    MapStart start = MapStart::known;
    Stamp searched{0};                       // for how long
    std::optional<Eigen::Matrix3d> R_first;  // orientation in the first image
  } loaded_;
  RelocalizationConfirmer confirmer_;
  Headings headings_;
  VisualResult result_;
};

}  // namespace slam
