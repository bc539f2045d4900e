// The SLAM filter: observations in, pose and map out. step() follows sections III, IV of Stasse et al. 2006.
#pragma once

#include "slam/internal_measurements.h"
#include "slam/vision/visual_tracking.h"

namespace slam {

/// An extended Kalman filter over the robot's state and the landmarks of its map. It reads no clock and draws
/// random numbers only from its own seeded generator, so that equal observations give equal results.
class Filter {
 public:
  /// Starts with the camera at X_WC_start and the initial covariance of the options. Throws
  /// std::invalid_argument if the calibration does not describe a valid camera.
  Filter(const Options& options, const Calibration& calibration, const Eigen::Isometry3d& X_WC_start,
         std::uint64_t seed);
  /// Processes one observation: prediction, internal measurements, active search, update and map management.
  /// A malformed observation, or one that is not later than the last, is rejected (FrameReport::refused) and
  /// changes nothing. The report is valid until the next call.
  const FrameReport& step(const Observation& observation);

  /// Starts from a map. The pose given to the constructor is then the start in it, as well as it is known.
  /// Until the map is recognized, the filter is lost, and its estimate is in a local frame. Call this before
  /// the first step.
  void start_from(const SavedMap& map, MapStart start);
  /// Returns the map for a later session, or nothing while a loaded one is not recognized.
  std::optional<SavedMap> saved_map() const;

  /// Records all later steps in a temporary file, so that smoothed() can return their poses.
  void record();
  /// Returns the poses of the recorded steps, each given all observations. Returns nothing if no step was
  /// recorded or the temporary file failed. Call it once, after the last step.
  std::optional<std::vector<SmoothedPose>> smoothed();

  const Estimate& estimate() const { return estimate_; }
  std::vector<MapPoint> map() const { return visual_.map(kalman_.state()); }

 private:
  std::optional<std::string> objection(const Observation& observation) const;
  DepthImage depth_image(const Observation& observation) const;
  const FrameReport& refuse(Stamp t, const std::string& why);
  void start_without_plan();
  void predict_and_update(const Observation& observation, const std::optional<PlannedInterval>& planned);
  void monitor(const Observation& observation, Stamp interval, const VisualResult& visual);
  void update_estimate(Stamp t);
  const FrameReport& complete_report();

  Options options_;
  Eigen::Isometry3d X_WC_start_;
  std::optional<AlignedDepth> depth_;
  std::unique_ptr<Smoother> smoother_;
  Kalman kalman_;
  InternalMeasurements internal_;
  VisualTracking visual_;
  TrackingMonitor tracking_;
  SensorMonitor sensors_;
  std::optional<Stamp> now_;                        // time of the last accepted observation
  Stamp interval_ = std::chrono::milliseconds(33);  // between the last two accepted observations
  int frames_ = 0;                                  // estimates made
  FrameReport report_;
  Estimate estimate_;
};

}  // namespace slam
