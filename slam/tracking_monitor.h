// Rejects unusable observations and images, and monitors tracking: what the images show, how many landmarks
// are found, and the innovations.
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "slam/frame_report.h"
#include "slam/observation.h"
#include "slam/options.h"
#include "slam/plan.h"

namespace slam {

/// Why the observation is malformed: an image of the wrong type or size, or a reading or plan that is not
/// finite. Empty if it is well-formed.
std::string malformation(const Observation& observation, const CameraIntrinsics& camera);

/// True if the camera is known to have stood still in a frame interval: the plan stands and the gyro reads
/// only noise. False if the options do not enable both sensors.
bool stands_still(const Observation& observation, const std::optional<PlannedInterval>& planned,
                  const Options& options);

struct ImageDefect {
  std::string reason;  ///< why the image cannot be used; empty if it can
  /// Nothing is seen. False for a repeated image that may be genuine: the camera is known to stand still, and
  /// not known to have noise.
  bool blinds = false;
};

/// Detects images that contain no information.
class ImageCheck {
 public:
  /// The defect of an image that is not empty: it is flat, or identical with the previous one.
  ImageDefect defect(const cv::Mat& image, bool stands_still);

 private:
  void look_for_noise(const cv::Mat& image);

  cv::Mat previous_;
  int noisy_ = 0;  // images that differed all over from the previous one while the camera stood still
};

/// The tracking statistics of one frame.
struct TrackingStatistics {
  double dt_s = 0;
  std::size_t searched = 0, accepted = 0;        ///< landmarks
  double coverage = 1;                           ///< fraction of the image that those searched for span
  std::optional<double> vision_nis, height_nis;  ///< per degree of freedom; absent without a measurement
};

/// True if almost none of the landmarks that were searched for all over the image is found. If they span only
/// a part of it, the rest of the image may be occluded, and this is false.
bool matching_failed(const TrackingStatistics& statistics);

/// The health of the filter over time.
class TrackingMonitor {
 public:
  explicit TrackingMonitor(const Options::Tracking& options) : options_(options) {}

  Health health() const { return health_; }
  const std::string& cause() const { return cause_; }
  /// True if matching failed in the last frame.
  bool in_doubt() const { return failing_s_ > 0; }
  /// True if tracking is lost because nothing was seen: the predicted pose and its covariance are still
  /// valid.
  bool is_blind() const { return health_ == Health::lost && blind_loss_; }

  /// Adds a frame; tracking may then be lost. Does nothing if the health is not ok.
  void judge(const TrackingStatistics& statistics);
  /// Adds a frame interval without anything usable seen, and why. Tracking is lost after lost_after_s of such
  /// intervals without sees() in between.
  void blind(Stamp interval, const std::string& why);
  /// Adds a rejected observation, and why. Its stamp may be wrong: each counts as one interval until one is
  /// accepted. Tracking is lost after lost_after_s of them and the filter has diverged after give_up_s more.
  void refuse(Stamp interval, const std::string& why);
  /// Adds an accepted observation.
  void accept() { refused_ = Stamp(0); }
  /// Something was seen: ends a loss caused by missing images.
  void sees();
  /// The filter is broken. The first cause is kept.
  void diverge(const std::string& cause);
  /// The map was recognized: the health is ok, and all earlier frames are forgotten.
  void relocalized() { *this = TrackingMonitor(options_); }
  /// How long tracking has been lost.
  Stamp lost_for() const { return health_ == Health::ok ? Stamp(0) : lost_; }
  /// A filter that was lost before this frame interval is lost after it; after give_up_s it has diverged.
  void remains_lost(Stamp interval);

 private:
  /// The mean of the last 15 values of a NIS.
  struct MovingMean {
    static constexpr std::size_t kWindow = 15;
    std::array<double, kWindow> values{};
    std::size_t count = 0;
    bool exceeds(const std::optional<double>& value, double bound);
  };

  std::string loss(const TrackingStatistics& statistics);
  void lose(const std::string& why);

  Options::Tracking options_;
  Health health_ = Health::ok;
  std::string cause_;
  double failing_s_ = 0;
  Stamp blind_{0}, refused_{0}, lost_{0};  // for how long
  bool blind_loss_ = false;
  MovingMean vision_, height_;
};

}  // namespace slam
