#include "slam/tracking_monitor.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "slam/vision/patch.h"

namespace slam {
namespace {

bool is_finite(const PlannedMotion& plan) {
  return plan.X_PC.matrix().allFinite() && plan.v_PC_C.allFinite() && plan.w_PC_C.allFinite() &&
         plan.p_CF.allFinite() &&
         (!plan.legs || (plan.legs->X_OC.matrix().allFinite() && plan.legs->p_CS.allFinite()));
}

/// Standard deviation of the gray values in every fourth row.
double contrast(const cv::Mat& image) {
  std::int64_t sum = 0, square = 0, count = 0;
  for (int row = 0; row < image.rows; row += 4) {
    const uchar* gray = image.ptr<uchar>(row);
    for (int column = 0; column < image.cols; ++column) {
      sum += gray[column];
      square += gray[column] * gray[column];
    }
    count += image.cols;
  }
  const double mean = static_cast<double>(sum) / static_cast<double>(count);
  return std::sqrt(std::max(0.0, static_cast<double>(square) / static_cast<double>(count) - mean * mean));
}

constexpr double kStandingSpeed = 1e-3;  // m/s and rad/s, planned
constexpr double kStill_rad_s = 0.02;
constexpr int kNoisyImages = 5;

double mean_gyro_rad_s(const std::vector<InertialSample>& gyro) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const InertialSample& reading : gyro) sum += reading.value;
  return sum.norm() / static_cast<double>(gyro.size());
}

constexpr double kLeastFound = 0.2;        // fraction of the landmarks searched for
constexpr double kLeastCoverage = 0.4;     // fraction of the image
constexpr std::size_t kLeastSearched = 5;  // landmarks
constexpr double kVisionBound = 3;         // mean NIS per degree of freedom, where 1 is expected
constexpr double kHeightBound = 10;        // mean NIS, where 1 is expected
constexpr const char* kNotFoundAgain = "; the map was not found again";

}  // namespace

std::string malformation(const Observation& o, const CameraIntrinsics& camera) {
  if (!o.image.empty() &&
      (o.image.type() != CV_8UC1 || o.image.cols != camera.width_px || o.image.rows != camera.height_px))
    return "its image is not 8-bit gray of the camera's size";
  for (const auto* samples : {&o.gyro, &o.accelerometer})
    for (const InertialSample& sample : *samples)
      if (!sample.value.allFinite() || sample.end < sample.begin) return "an inertial reading is not finite";
  if (o.plan && !is_finite(*o.plan)) return "its plan is not finite";
  return "";
}

bool stands_still(const Observation& o, const std::optional<PlannedInterval>& planned,
                  const Options& options) {
  return options.plan_velocity.enabled && planned && planned->plan.velocity.norm() < kStandingSpeed &&
         planned->plan.rate.norm() < kStandingSpeed && options.gyro.enabled && !o.gyro.empty() &&
         mean_gyro_rad_s(o.gyro) < kStill_rad_s;
}

/// Differences all over two images of a camera at rest are its noise.
void ImageCheck::look_for_noise(const cv::Mat& image) {
  if (previous_.empty() || noisy_ >= kNoisyImages) return;
  int differing = 0, count = 0;
  for (int row = 0; row < image.rows; row += 4, count += image.cols) {
    const uchar *now = image.ptr<uchar>(row), *before = previous_.ptr<uchar>(row);
    for (int column = 0; column < image.cols; ++column) differing += now[column] != before[column];
  }
  noisy_ = 2 * differing > count ? noisy_ + 1 : 0;
}

ImageDefect ImageCheck::defect(const cv::Mat& image, bool stands_still) {
  const bool frozen =
      !previous_.empty() && std::equal(image.begin<uchar>(), image.end<uchar>(), previous_.begin<uchar>());
  if (stands_still && !frozen) look_for_noise(image);
  image.copyTo(previous_);
  if (contrast(image) < kFlatContrast) return {"the image is flat", true};
  if (frozen) return {"the image is the last one again", !stands_still || noisy_ >= kNoisyImages};
  return {};
}

bool matching_failed(const TrackingStatistics& s) {
  return s.searched >= kLeastSearched && s.coverage > kLeastCoverage &&
         static_cast<double>(s.accepted) < kLeastFound * static_cast<double>(s.searched);
}

/// Adds a value, if there is one; returns true if the window is full and its mean exceeds the bound.
bool TrackingMonitor::MovingMean::exceeds(const std::optional<double>& value, double bound) {
  if (!value) return false;
  values[count++ % kWindow] = *value;
  return count >= kWindow && std::accumulate(values.begin(), values.end(), 0.0) > bound * kWindow;
}

/// Why tracking is lost with this frame; empty if it is not.
std::string TrackingMonitor::loss(const TrackingStatistics& s) {
  failing_s_ = matching_failed(s) ? failing_s_ + s.dt_s : 0;
  const bool vision = vision_.exceeds(s.vision_nis, kVisionBound);
  const bool height = height_.exceeds(s.height_nis, kHeightBound);
  if (failing_s_ > options_.lost_after_s) return "almost no landmark found";
  if (vision) return "matches are further from their predicted pixels than the covariance allows";
  if (height) return "the height is further from the planned one than the covariance allows";
  return "";
}

void TrackingMonitor::judge(const TrackingStatistics& statistics) {
  if (health_ != Health::ok) return;
  const std::string why = loss(statistics);
  if (!why.empty()) lose(why);
}

void TrackingMonitor::lose(const std::string& why) {
  health_ = Health::lost;
  cause_ = "tracking lost: " + why;
  refused_ = lost_ = Stamp(0);
  blind_loss_ = false;
}

void TrackingMonitor::blind(Stamp interval, const std::string& why) {
  blind_ += interval;
  if (health_ != Health::ok || !(seconds(blind_) > options_.lost_after_s)) return;
  lose(why);
  blind_loss_ = true;
}

void TrackingMonitor::refuse(Stamp interval, const std::string& why) {
  refused_ += interval;
  if (health_ == Health::lost && seconds(refused_) > options_.give_up_s)
    return diverge(cause_ + kNotFoundAgain);
  if (health_ != Health::ok || !(seconds(refused_) > options_.lost_after_s)) return;
  lose("observations are rejected because " + why);
  blind_loss_ = true;
}

void TrackingMonitor::sees() {
  blind_ = Stamp(0);
  if (!is_blind()) return;
  health_ = Health::ok;
  cause_.clear();
}

void TrackingMonitor::diverge(const std::string& cause) {
  if (health_ == Health::diverged) return;
  health_ = Health::diverged;
  cause_ = cause;
}

void TrackingMonitor::remains_lost(Stamp interval) {
  if (health_ != Health::lost) return;
  lost_ += interval;
  if (seconds(lost_) > options_.give_up_s) diverge(cause_ + kNotFoundAgain);
}

}  // namespace slam
