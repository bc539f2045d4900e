#include "slam/monitors.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "slam/vision/patch.h"

namespace slam {
namespace {

constexpr double kStill_rad_s = 0.02;
constexpr int kNoisyImages = 5;

constexpr double kLeastFound = 0.2;        // fraction of the landmarks searched for
constexpr double kLeastCoverage = 0.4;     // fraction of the image
constexpr std::size_t kLeastSearched = 5;  // landmarks
constexpr double kVisionBound = 3;         // mean NIS per degree of freedom, where 1 is expected
constexpr double kLegFactor = 1.5;   // factor on plan_bound, because leg odometry's errors last many frames
constexpr double kHeightBound = 10;  // mean NIS, where 1 is expected
constexpr const char* kNotFoundAgain = "; the map was not found again";

constexpr double kEvidenceMemory_s = 30;
constexpr double kOrdinary = 0.02;  // relative systematic error
constexpr double kScatter = 1.5;    // bound on the gyro's scatter, relative to the assumed noise
// Fraction of second differences larger than the first ones: 0.77 for noise (0.5 + asin(2/sqrt(7))/pi), and
// at most 0.6 with a policy whose trunk shakes as fast as the gyro's noise.
constexpr double kWhite = 0.64;
constexpr double kMemory = 1200;  // second differences: 2 s of three axes
constexpr double kFewest = 600;   // second differences

constexpr double kTurnMemory_s = 3;
// Without faults, the difference in this time is at most 0.02 rad on the circles, and 0.11 rad if the
// friction is only 0.1.
constexpr double kLargestTurn_rad = 0.2;

constexpr double kInnovationMemory_s = 5;
constexpr double kFewestFrames = 30;

constexpr double kImageMemory_s = 5;
constexpr double kFewestSearches = 60;
constexpr double kLeastFoundAgain = 0.6;  // fraction of the landmarks searched for
constexpr double kMostUnreliable = 4;     // landmarks within the memory
constexpr double kLossMemory_s = 20;
constexpr double kLossLasts_s = 2;   // a loss that lasts this long counts as a second one
constexpr double kMostLosses = 1.5;  // within the memory
constexpr double kRecovered = 0.5;   // fraction of a loss that still counts, since the images now fit the map

bool is_finite(const PlannedMotion& plan) {
  return plan.X_PC.matrix().allFinite() && plan.v_PC_C.allFinite() && plan.w_PC_C.allFinite() &&
         plan.p_CF.allFinite();
}

double contrast(const cv::Mat& image) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  return deviation[0];
}

/// Returns whether any patch of the image has the contrast of a template.
bool has_texture(const cv::Mat& image) {
  const cv::Size patch(kPatchSide, kPatchSide);
  cv::Mat mean, squares;
  cv::boxFilter(image, mean, CV_32F, patch);
  cv::sqrBoxFilter(image, squares, CV_32F, patch);
  double largest = 0;
  cv::minMaxLoc(squares - mean.mul(mean), nullptr, &largest);
  return largest >= kFlatContrast * kFlatContrast;
}

double length_s(const InertialSample& reading) { return seconds(reading.end - reading.begin); }

bool follows(const InertialSample& next, const InertialSample& reading) {
  return next.begin == reading.end && std::abs(length_s(next) - length_s(reading)) < 1e-4 &&
         length_s(next) > 0;
}

}  // namespace

std::optional<std::string> malformation(const Observation& o, const CameraIntrinsics& camera) {
  if (!o.image.empty() &&
      (o.image.type() != CV_8UC1 || o.image.cols != camera.width_px || o.image.rows != camera.height_px))
    return "the image is not an 8-bit gray image of the camera's size";
  for (const auto* samples : {&o.gyro, &o.accelerometer})
    for (const InertialSample& sample : *samples)
      if (!sample.value.allFinite() || sample.end < sample.begin) return "an inertial reading is not finite";
  if (o.plan && !is_finite(*o.plan)) return "the plan is not finite";
  if (o.legs && !(o.legs->X_OC.matrix().allFinite() && o.legs->p_CS.allFinite()))
    return "the leg odometry is not finite";
  if (const auto& c = o.command; c && !Eigen::Vector3d(c->ahead_m_s, c->left_m_s, c->turn_rad_s).allFinite())
    return "the command is not finite";
  return std::nullopt;
}

bool stands_still(const Observation& o, const std::optional<PlannedInterval>& planned,
                  const Options& options) {
  if (!options.plan_velocity.enabled || !planned || !planned->standing || !options.gyro.enabled) return false;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const InertialSample& reading : o.gyro) sum += reading.value;
  return !o.gyro.empty() && sum.norm() / static_cast<double>(o.gyro.size()) < kStill_rad_s;
}

std::optional<ImageDefect> ImageCheck::defect(const cv::Mat& image, bool stands_still) {
  const bool frozen =
      !previous_.empty() && std::equal(image.begin<uchar>(), image.end<uchar>(), previous_.begin<uchar>());
  if (stands_still && !frozen && !previous_.empty() && noisy_ < kNoisyImages) {
    const int differing = cv::countNonZero(image != previous_);  // everywhere, at rest: noise
    noisy_ = 2 * differing > image.rows * image.cols ? noisy_ + 1 : 0;
  }
  image.copyTo(previous_);
  // Twice the contrast in every fourth row is enough for the image to have it.
  const cv::Mat rows((image.rows + 3) / 4, image.cols, CV_8UC1, image.data, 4 * image.step[0]);
  if (contrast(rows) < 2 * kFlatContrast && contrast(image) < kFlatContrast && !has_texture(image))
    return ImageDefect{"the image is flat", true};
  if (!frozen) return std::nullopt;
  return ImageDefect{"the image is identical to the previous one", !stands_still || noisy_ >= kNoisyImages};
}

bool matching_failed(const TrackingStatistics& s) {
  return s.searched >= kLeastSearched && s.coverage > kLeastCoverage &&
         static_cast<double>(s.accepted) < kLeastFound * static_cast<double>(s.searched);
}

/// Adds a value, if there is one; returns true if the window is full and its mean exceeds the bound.
bool TrackingMonitor::MovingMean::exceeds(const std::optional<double>& value, double bound) {
  if (!value) return false;
  values[count++ % values.size()] = *value;
  return count >= values.size() &&
         std::accumulate(values.begin(), values.end(), 0.0) > bound * static_cast<double>(values.size());
}

void TrackingMonitor::judge(const TrackingStatistics& s) {
  const bool failed = matching_failed(s);
  in_doubt_ = failed || (in_doubt_ && s.accepted < kLeastInDoubt);
  if (health_ != Health::ok) return;
  failing_s_ = std::max(0.0, failing_s_ + (failed ? s.dt_s : -s.dt_s));
  const bool vision = vision_.exceeds(s.vision_nis, kVisionBound);
  const bool height = height_.exceeds(s.height_nis, kHeightBound);
  if (failing_s_ > options_.lost_after_s) return lose("almost no landmarks were found", true);
  if (vision) return lose("matches are further from their predicted pixels than the covariance allows");
  if (height) return lose("the height is further from the planned one than the covariance allows");
}

void TrackingMonitor::lose(const std::string& why, bool blind) {
  health_ = Health::lost;
  cause_ = "tracking lost: " + why;
  refused_ = lost_ = Stamp(0);
  blind_loss_ = blind;
}

void TrackingMonitor::blind(Stamp interval, const std::string& why, bool knows_pose) {
  blind_ += interval;
  if (health_ != Health::ok || (seconds(blind_) <= options_.lost_after_s && knows_pose)) return;
  lose(why, true);
  const std::chrono::duration<double> allowed(options_.lost_after_s);
  lost_ = std::min(Stamp(0), blind_ - std::chrono::duration_cast<Stamp>(allowed));  // not to give up early
}

void TrackingMonitor::refuse(Stamp interval, const std::string& why) {
  refused_ += interval;
  if (health_ == Health::lost && seconds(refused_) > options_.give_up_s)
    return diverge(*cause_ + kNotFoundAgain);
  if (health_ == Health::ok && seconds(refused_) > options_.lost_after_s)
    lose("observations are rejected because " + why, true);
}

void TrackingMonitor::sees() {
  if (is_blind()) return relocalized();
  blind_ = Stamp(0);
}

void TrackingMonitor::diverge(const std::string& cause) {
  if (health_ == Health::diverged) return;
  health_ = Health::diverged;
  cause_ = cause;
}

void TrackingMonitor::remains_lost(Stamp interval) {
  if (health_ != Health::lost) return;
  lost_ += interval;
  if (seconds(lost_) > options_.give_up_s) diverge(*cause_ + kNotFoundAgain);
}

void GyroNoiseTest::add(const std::vector<InertialSample>& readings) {
  for (const InertialSample& reading : readings) {
    if (follows(reading, last_) && follows(last_, before_)) {
      const double sigma = options_.sigma_rad_s * std::sqrt(6 * kReadingPeriod_s / length_s(reading));
      const Eigen::Vector3d second = reading.value - 2 * last_.value + before_.value;
      const double median = 0.6745 * sigma;  // median of the absolute value of a normal variable
      beyond_ += static_cast<double>((second.array().abs() > kScatter * median).count());
      white_ +=
          static_cast<double>((second.array().abs() > (reading.value - last_.value).array().abs()).count());
      count_ += 3;
      const double keep = count_ > kMemory ? kMemory / count_ : 1;
      count_ *= keep, beyond_ *= keep, white_ *= keep;
    }
    before_ = last_;
    last_ = reading;
  }
}

bool GyroNoiseTest::scatters() const {
  return count_ >= kFewest && beyond_ > 0.5 * count_ && white_ > kWhite * count_;
}

void TurnTest::add(double dt_s, double difference_rad) {
  difference_rad_ = std::exp(-dt_s / kTurnMemory_s) * difference_rad_ + difference_rad;
}

bool TurnTest::fails() const { return std::abs(difference_rad_) > kLargestTurn_rad; }

void ImageTest::add(double dt_s, std::size_t searched, std::size_t accepted, std::size_t unreliable) {
  const double keep = std::exp(-dt_s / kImageMemory_s);
  searched_ = keep * searched_ + static_cast<double>(searched);
  accepted_ = keep * accepted_ + static_cast<double>(accepted);
  unreliable_ = keep * unreliable_ + static_cast<double>(unreliable);
}

void ImageTest::add_health(double dt_s, bool lost, bool good_image) {
  losses_ *= std::exp(-dt_s / kLossMemory_s);
  const bool begins = lost && !lost_;
  if (begins) loss_counts_ = good_image, before_ = losses_;
  if (!lost && lost_ && loss_counts_) losses_ = before_ + kRecovered;
  if (lost && loss_counts_) losses_ += begins ? 1 : dt_s / kLossLasts_s;
  lost_ = lost;
}

bool ImageTest::fails() const {
  const bool not_found = searched_ > kFewestSearches && accepted_ < kLeastFoundAgain * searched_;
  return (not_found && unreliable_ > kMostUnreliable) || losses_ > kMostLosses;
}

void InnovationTest::add(double dt_s, const std::optional<Nis>& nis) {
  const double keep = std::exp(-dt_s / kInnovationMemory_s);
  nis_ *= keep, dof_ *= keep, frames_ *= keep;
  if (nis) nis_ += nis->value, dof_ += nis->dof, ++frames_;
}

bool InnovationTest::fails() const { return frames_ > kFewestFrames && nis_ > largest_nis_ * dof_; }

void SensorMonitor::add(const Evidence& evidence, double dt_s) {
  const double keep = std::exp(-dt_s / kEvidenceMemory_s);
  for (std::size_t k = 0; k < evidence.size(); ++k) {
    sums_[k].score = keep * sums_[k].score + evidence[k].score;
    sums_[k].information = keep * sums_[k].information + evidence[k].information;
  }
}

double SensorMonitor::sigmas(int error) const {
  const auto& [score, information] = sums_[static_cast<std::size_t>(error)];
  if (!(information > 0)) return 0;
  const double delta = score / information;
  return std::copysign(std::max(0.0, std::abs(delta) - kOrdinary), delta) * std::sqrt(information);
}

std::optional<std::string> SensorMonitor::suspect() const {
  if (options_.gyro.enabled && gyro_.scatters())
    return "inconsistent: gyro, its readings scatter more than 1.5 times as much as assumed";
  if (options_.gyro.enabled && turns_.fails())
    return "inconsistent: gyro, it turns differently from the legs";
  if (images_.fails()) return "inconsistent: images, landmarks are not found at their predicted pixels";
  if (matches_.fails()) return "inconsistent: images, their matches scatter more than assumed";
  if (height_.fails()) return "inconsistent: height, the floor is not level";
  if (legs_.fails()) return "inconsistent: leg odometry, its velocities scatter more than assumed";
  const Options::Tracking& bounds = options_.tracking;
  const bool has_vision = options_.vision.enabled,
             has_scale = has_vision && options_.plan_velocity.enabled && options_.accelerometer.enabled;
  struct Error {
    bool tested;
    int index;
    double bound;
    const char *what, *more, *less;
  };
  for (const Error& e :
       {Error{has_vision, kLensDistortion, bounds.lens_bound,
              "images, the assumed distortion of the lens is too ", "large", "small"},
        {has_scale, kLegScale, kLegFactor * bounds.plan_bound, "leg odometry, its distances are too ", "long",
         "short"},
        {has_scale, kPlanScale, bounds.plan_bound, "plan, its distances are too ", "long", "short"}})
    if (const double wrong = sigmas(e.index); e.tested && std::abs(wrong) > e.bound)
      return std::string("inconsistent: ") + e.what + (wrong > 0 ? e.more : e.less) + " by " +
             std::to_string(std::lround(std::abs(wrong))) + " standard deviations";
  return std::nullopt;
}

}  // namespace slam
