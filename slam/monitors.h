// Monitors of the filter's inputs and of tracking: unusable observations and images, the health of the
// filter, and sensors that contradict their models.
#pragma once

#include "slam/sensors.h"

namespace slam {

/// Why the observation is malformed: an image of the wrong type or size, or a reading or plan that is not
/// finite. Nothing if it is well-formed.
std::optional<std::string> malformation(const Observation& observation, const CameraIntrinsics& camera);

/// True if the camera is known to have stood still in a frame interval: the plan stands and the gyro reads
/// only noise. False if the options do not enable both sensors.
bool stands_still(const Observation& observation, const std::optional<PlannedInterval>& planned,
                  const Options& options);

struct ImageDefect {
  std::string reason;  ///< why the image cannot be used
  /// Nothing is seen; false for a repeated image that may be genuine, of a still camera without known noise.
  bool blinds = false;
};

/// Detects images that contain no information.
class ImageCheck {
 public:
  /// The defect, if any, of an image that is not empty: it is flat, or identical with the previous one.
  std::optional<ImageDefect> defect(const cv::Mat& image, bool stands_still);

 private:
  cv::Mat previous_;
  int noisy_ = 0;  // images that differed all over from the previous one while the camera stood still
};

/// The tracking statistics of one frame.
struct TrackingStatistics {
  double dt_s = 0;
  std::size_t searched = 0, accepted = 0;        ///< landmarks; set aside ones count as searched for
  double coverage = 1;                           ///< fraction of the image that all in view span
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
  /// Why the health is not ok.
  const std::optional<std::string>& cause() const { return cause_; }
  /// True if matching failed in the last frame.
  bool in_doubt() const { return in_doubt_; }
  /// True if tracking is lost because nothing was seen: the prediction and its covariance are still valid.
  bool is_blind() const { return health_ == Health::lost && blind_loss_; }
  /// Adds a frame; tracking may then be lost. Does nothing if the health is not ok.
  void judge(const TrackingStatistics& statistics);
  /// Adds a frame interval without anything usable seen, and why. Tracking is lost after lost_after_s of such
  /// intervals without sees() in between, or once the predicted pose is too uncertain.
  void blind(Stamp interval, const std::string& why, bool knows_pose = true);
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
  /// How long tracking has been lost; negative after an early loss without sight.
  Stamp lost_for() const { return health_ == Health::ok ? Stamp(0) : lost_; }
  /// A filter that was lost before this frame interval is lost after it; after give_up_s it has diverged.
  void remains_lost(Stamp interval);

 private:
  /// The mean of the last 15 values of a NIS.
  struct MovingMean {
    std::array<double, 15> values{};
    std::size_t count = 0;
    bool exceeds(const std::optional<double>& value, double bound);
  };

  void lose(const std::string& why, bool blind = false);

  Options::Tracking options_;
  Health health_ = Health::ok;
  std::optional<std::string> cause_;
  bool in_doubt_ = false;
  double failing_s_ = 0;                   // matching failed for so much longer than it did not
  Stamp blind_{0}, refused_{0}, lost_{0};  // for how long
  bool blind_loss_ = false;
  MovingMean vision_, height_;
};

/// Compares the scatter of successive gyro readings with the assumed noise. Second differences of readings 5
/// ms apart are almost independent of a walk, and their median is independent of impacts. Of a robot that
/// shakes they are large, too, but smaller than the first differences.
class GyroNoiseTest {
 public:
  explicit GyroNoiseTest(const Options::Gyro& options) : options_(options) {}

  void add(const std::vector<InertialSample>& readings);
  /// True if the median of the last seconds' second differences is more than 1.5 times that of the noise, and
  /// most of them are larger than the first differences.
  bool scatters() const;

 private:
  Options::Gyro options_;
  InertialSample last_, before_;
  double count_ = 0, beyond_ = 0, white_ = 0;  // of second differences, older ones weighing less
};

/// Compares the number of landmarks found again with that predicted. Images of another place or another
/// motion give ever new landmarks that are not found again, and tracking is lost although they are good.
class ImageTest {
 public:
  /// Adds whether tracking is lost after a frame. A loss that started with a bad image does not count.
  void add_health(double dt_s, bool lost, bool good_image);
  /// Adds how many landmarks of a frame were searched for, accepted, and soon deleted again as unreliable.
  void add(double dt_s, std::size_t searched, std::size_t accepted, std::size_t unreliable);

  bool fails() const;

 private:
  double searched_ = 0, accepted_ = 0, unreliable_ = 0;  // older ones weigh less
  bool lost_ = false, loss_counts_ = false;
  double losses_ = 0;  // older ones weigh less; one more for every two seconds of a loss
  double before_ = 0;  // the last loss
};

/// Tests the sensors against their models. A constant systematic error δ from the start is tested against
/// δ = 0 (Willsky & Jones 1976: generalized likelihood ratio); the filter keeps ∂ν/∂δ of every innovation ν.
/// Evidence is forgotten with a time constant of 30 s, and an error of up to 2 % is ordinary: otherwise the
/// small error of every plan would become certain on a long walk.
class SensorMonitor {
 public:
  explicit SensorMonitor(const Options& options) : options_(options), gyro_(options.gyro) {}
  /// dt_s: the interval since the previous evidence.
  void add(const Evidence& evidence, double dt_s);
  GyroNoiseTest& gyro() { return gyro_; }
  ImageTest& images() { return images_; }
  /// Forgets the evidence of the innovations, after a new pose.
  void reset() { sums_ = {}; }
  /// The distance of the estimated δ from ±2 % in its standard deviations, with its sign; 0 within ±2 %.
  double sigmas(int error) const;
  /// "inconsistent: plan, its distances are too long by 9 standard deviations" or the like; nothing if all is
  /// consistent. The gyro comes first and the plan last: the evidence against it depends on the others.
  std::optional<std::string> suspect() const;

 private:
  Options options_;
  Evidence sums_{};
  GyroNoiseTest gyro_;
  ImageTest images_;
};

}  // namespace slam
