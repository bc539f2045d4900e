// The SLAM filter: observations in, pose and map out. step() follows sections III and IV of Stasse et al.
// 2006.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slam/camera.h"
#include "slam/frame_report.h"
#include "slam/internal_measurements.h"
#include "slam/kalman.h"
#include "slam/map.h"
#include "slam/observation.h"
#include "slam/observation_check.h"
#include "slam/options.h"
#include "slam/relocalisation.h"
#include "slam/sensor_watch.h"
#include "slam/tracking_watch.h"
#include "slam/vision.h"

namespace slam {

/// An extended Kalman filter over the robot's state and the landmarks of its map. It reads no clock and draws
/// random numbers from its own seeded generator only, so that equal observations give equal results.
class Filter {
 public:
  /// Starts with the camera at X_WC_start and the initial covariance of the options. Throws
  /// std::invalid_argument if the calibration is not that of a camera.
  Filter(const Options& options, const Calibration& calibration, const Eigen::Isometry3d& X_WC_start,
         std::uint64_t seed);

  /// Takes in one observation: prediction, internal measurements, active search, update and map management.
  /// A malformed observation, or one whose time does not increase, is refused (FrameReport::refused) and
  /// changes nothing. The report is valid until the next call.
  const FrameReport& step(const Observation& observation);

  const Estimate& estimate() const { return estimate_; }
  std::vector<MapPoint> map() const { return map_.points(kalman_.state()); }

 private:
  void clear_report(Stamp t);
  std::string objection(const Observation& observation) const;
  void refuse_whole();
  void refuse(const std::string& reason);
  void predict_and_measure_internally(const Observation& observation,
                                      const std::optional<PlannedVelocity>& planned);
  void look(const Observation& observation, Stamp interval, const std::optional<PlannedVelocity>& planned);
  std::string measure_visually(const Observation& observation, double dt_s);
  void use_matches(const cv::Mat& image, const VisionResult& vision);
  void report_vision(const VisionResult& vision);
  void report_initialised(std::size_t first);
  InitialisationCount manage_map(const Observation& observation, const VisionResult& vision, bool may_initialise);
  void relocalise_in(const Observation& observation);
  void judge_sensors(const Observation& observation, double dt);
  void publish();
  void report_health();

  Options options_;
  Camera camera_;
  Kalman kalman_;
  InternalMeasurements internal_;
  ImageCheck image_check_;
  Vision vision_;
  Map map_;
  TrackingWatch tracking_;
  Recognition recognition_;
  SensorWatch sensor_watch_;
  std::optional<Stamp> now_;       // of the last observation taken in
  Stamp interval_ = std::chrono::milliseconds(33);  // between the last two observations taken in
  bool good_image_ = false;   // of this frame: not missing, flat or frozen, and the next one after the last
  int frames_ = 0;            // estimates published
  FrameReport report_;
  Estimate estimate_;
};

}  // namespace slam
