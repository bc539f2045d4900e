// Monitors of the filter's inputs and of tracking: unusable observations and images, the health of the
// filter, and sensors that contradict their models.
#pragma once

#include "slam/sensors.h"

namespace slam {

/// Returns why the observation is malformed: an image of the wrong type or size, or a reading or plan
/// that is not finite. Returns nothing if it is well-formed.
std::optional<std::string> malformation(const Observation& observation, const CameraIntrinsics& camera);

/// True if the camera is known to have stood still in a frame interval: the robot stands still according to
/// the plan, and the gyro reads only noise. False if the options do not enable both sensors.
bool stands_still(const Observation& observation, const std::optional<PlannedInterval>& planned,
                  const Options& options);

struct ImageDefect {
  std::string reason;  ///< why the image cannot be used
  /// True if nothing is seen. False for a repeated image that may be genuine: the camera stands still and is
  /// not known to have noise.
  bool blinds = false;
};

/// Detects images that contain no information.
class ImageCheck {
 public:
  /// The defect, if any, of an image that is not empty: it is flat, or identical to the previous one.
  std::optional<ImageDefect> defect(const cv::Mat& image, bool stands_still);

 private:
  cv::Mat previous_;
  // Number of images that differed everywhere from the previous one while the camera stood still.
  int noisy_ = 0;
};

/// The tracking statistics of one frame.
struct TrackingStatistics {
  double dt_s = 0;
  std::size_t searched = 0, accepted = 0;        ///< landmarks; any set aside count as searched for
  double coverage = 1;                           ///< fraction of the image spanned by all landmarks in view
  std::optional<double> vision_nis, height_nis;  ///< per degree of freedom; absent without a measurement
};

/// True if landmarks were searched for in all parts of the image and almost none was found. If they span only
/// a part of the image, the rest may be occluded, and this is false.
bool matching_failed(const TrackingStatistics& statistics);

/// Landmarks that must be found together after a failure, since few matches occur by chance.
constexpr std::size_t kLeastInDoubt = 4;

/// The health of the filter over time.
class TrackingMonitor {
 public:
  explicit TrackingMonitor(const Options::Tracking& options) : options_(options) {}

  Health health() const { return health_; }
  /// Why the health is not ok.
  const std::optional<std::string>& cause() const { return cause_; }
  /// True if matching failed, and never as many as kLeastInDoubt landmarks were found since.
  bool in_doubt() const { return in_doubt_; }
  /// True if tracking is lost because nothing was seen: the prediction and its covariance are still valid.
  bool is_blind() const { return health_ == Health::lost && blind_loss_; }
  /// Adds a frame; tracking may then be lost. Does nothing if the health is not ok.
  void judge(const TrackingStatistics& statistics);
  /// Adds a frame interval in which nothing usable was seen, and why. Tracking is lost after lost_after_s of
  /// such intervals without sees() in between, or once the predicted pose is too uncertain.
  void blind(Stamp interval, const std::string& why, bool knows_pose = true);
  /// Adds a rejected observation, and why. Its stamp may be wrong, so each counts as one interval until one
  /// is accepted. Tracking is lost after lost_after_s of them and the filter has diverged after give_up_s
  /// more.
  void refuse(Stamp interval, const std::string& why);
  /// Adds an accepted observation.
  void accept() { refused_ = Stamp(0); }
  /// Something was seen: ends a loss caused by missing images.
  void sees();
  /// Tracking starts lost, and is given up only by the caller.
  void search() { lose("the loaded map is not recognized yet"); }
  /// The filter is broken. The first cause is kept.
  void diverge(const std::string& cause);
  /// The map was recognized: the health is ok, and all earlier frames are forgotten.
  void relocalized() { *this = TrackingMonitor(options_); }
  /// Returns how long tracking has been lost; negative after a loss that was declared early because nothing
  /// was seen.
  Stamp lost_for() const { return health_ == Health::ok ? Stamp(0) : lost_; }
  /// Adds a frame interval after which a lost filter is still lost; after give_up_s it has diverged.
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
  double failing_s_ = 0;                   // time for which matching failed minus time for which it succeeded
  Stamp blind_{0}, refused_{0}, lost_{0};  // for how long
  bool blind_loss_ = false;
  MovingMean vision_, height_;
};

/// Compares the scatter of successive gyro readings with the assumed noise. Walking hardly affects the second
/// differences of readings 5 ms apart, and impacts do not affect their median. A shaking robot makes them
/// large, too, but then fewer of them are larger than the first differences.
class GyroNoiseTest {
 public:
  explicit GyroNoiseTest(const Options::Gyro& options) : options_(options) {}

  void add(const std::vector<InertialSample>& readings);
  /// True if the median of the second differences in the last seconds is more than 1.5 times the noise's
  /// median, and as many of them are larger than the first differences as with noise.
  bool scatters() const;

 private:
  Options::Gyro options_;
  InertialSample last_, before_;
  double count_ = 0, beyond_ = 0, white_ = 0;  // numbers of second differences; older ones weigh less
};

/// Compares the turns of the gyro with those of the legs, in the last seconds. A gyro whose readings are
/// scaled or constant turns by another angle.
class TurnTest {
 public:
  /// difference_rad: the turn about the vertical by the gyro minus the one by leg odometry, in a frame
  /// interval.
  void add(double dt_s, double difference_rad);
  bool fails() const;

 private:
  double difference_rad_ = 0;  // older ones weigh less
};

/// Compares the number of landmarks found again with the number predicted. With images of a different place
/// or motion, new landmarks keep being added that are not found again, and tracking is lost although the
/// images are good.
class ImageTest {
 public:
  /// Records whether tracking is lost after a frame. A loss that started with a bad image does not count.
  void add_health(double dt_s, bool lost, bool good_image);
  /// Records how many landmarks of a frame were searched for, accepted, and soon deleted again as unreliable.
  void add(double dt_s, std::size_t searched, std::size_t accepted, std::size_t unreliable);

  bool fails() const;

 private:
  double searched_ = 0, accepted_ = 0, unreliable_ = 0;  // older ones weigh less
  bool lost_ = false, loss_counts_ = false;
  double losses_ = 0;  // older ones weigh less; one more for every two seconds of a loss
  double before_ = 0;  // losses_ before the last loss
};

/// Compares the innovations of a sensor with their covariance. They are too large if its assumed noise is too
/// small or, for the height, if the floor is not level.
class InnovationTest {
 public:
  /// largest_nis: per degree of freedom, averaged over the last seconds.
  explicit InnovationTest(double largest_nis) : largest_nis_(largest_nis) {}
  void add(double dt_s, const std::optional<Nis>& nis);
  /// True if the mean NIS is larger.
  bool fails() const;
  void reset() { nis_ = dof_ = frames_ = 0; }

 private:
  double largest_nis_;
  double nis_ = 0, dof_ = 0, frames_ = 0;  // older ones weigh less
};

/// Tests the sensors against their models. A constant systematic error δ from the start is tested against δ =
/// 0 (Willsky & Jones 1976: generalized likelihood ratio); the filter keeps ∂ν/∂δ of every innovation ν.
/// Evidence is forgotten with a time constant of 30 s, and an error of up to 2 % counts as ordinary.
/// Otherwise the small error of every plan would become significant on a long walk.
class SensorMonitor {
 public:
  explicit SensorMonitor(const Options& options) : options_(options), gyro_(options.gyro) {}
  /// dt_s: the interval since the previous evidence.
  void add(const Evidence& evidence, double dt_s);
  GyroNoiseTest& gyro() { return gyro_; }
  TurnTest& turns() { return turns_; }
  ImageTest& images() { return images_; }
  InnovationTest& matches() { return matches_; }
  InnovationTest& legs() { return legs_; }
  InnovationTest& height() { return height_; }
  /// Forgets the evidence of the innovations, after the pose was reset.
  void reset() { sums_ = {}, matches_.reset(), legs_.reset(), height_.reset(); }
  /// How far the estimated δ lies outside ±2 %, in its standard deviations and with its sign; 0 within ±2 %.
  double sigmas(int error) const;
  /// Returns a message such as "inconsistent: plan, its distances are too long by 9 standard deviations", or
  /// nothing if all is consistent. The gyro comes first and the plan last, because the evidence against the
  /// plan depends on the others.
  std::optional<std::string> suspect() const;

 private:
  Options options_;
  Evidence sums_{};
  GyroNoiseTest gyro_;
  TurnTest turns_;
  ImageTest images_;
  // With right noises the largest means are 1.5 (matches), 0.9 (legs) and 1.5 (height). On a ramp that is
  // assumed to be level, the height's mean reaches 8 to 35; if matches scatter four times as much as assumed,
  // theirs is 7.
  InnovationTest matches_{3}, legs_{1.5}, height_{3};
};

}  // namespace slam
