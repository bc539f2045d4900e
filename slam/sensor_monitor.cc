#include "slam/sensor_monitor.h"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kEvidenceMemory_s = 30;
constexpr double kOrdinary = 0.02;  // relative systematic error
constexpr double kScatter = 1.5;    // of the gyro, relative to what is assumed
constexpr double kMemory = 1200;    // second differences: 2 s of three axes
constexpr double kFewest = 600;     // second differences
constexpr double kImageMemory_s = 5;
constexpr double kFewestSearches = 60;
constexpr double kLeastFound = 0.6;    // of the landmarks searched for
constexpr double kMostUnreliable = 4;  // landmarks within the memory
constexpr double kLossMemory_s = 20;
constexpr double kLossLasts_s = 2;   // as bad as another loss
constexpr double kMostLosses = 1.5;  // within the memory

double length_s(const InertialSample& reading) { return seconds(reading.end - reading.begin); }

bool follows(const InertialSample& next, const InertialSample& reading) {
  return next.begin == reading.end && std::abs(length_s(next) - length_s(reading)) < 1e-4 &&
         length_s(next) > 0;
}

std::string by_sigmas(const char* what, double sigmas, const char* more, const char* less) {
  return std::string("inconsistent: ") + what + (sigmas > 0 ? more : less) + " by " +
         std::to_string(std::lround(std::abs(sigmas))) + " standard deviations";
}

}  // namespace

void SystematicErrorTest::add(const SystematicEvidence& evidence, double dt_s) {
  const double keep = std::exp(-dt_s / kEvidenceMemory_s);
  sum_.score = keep * sum_.score + evidence.score;
  sum_.information = keep * sum_.information + evidence.information;
}

double SystematicErrorTest::sigmas() const {
  if (!(sum_.information > 0)) return 0;
  const double error = sum_.score / sum_.information;
  return std::copysign(std::max(0.0, std::abs(error) - kOrdinary), error) * std::sqrt(sum_.information);
}

void GyroNoiseTest::add(const std::vector<InertialSample>& readings) {
  for (const InertialSample& reading : readings) {
    if (follows(reading, last_) && follows(last_, before_)) {
      const double sigma = options_.sigma_rad_s * std::sqrt(6 * kReadingPeriod_s / length_s(reading));
      const Eigen::Vector3d second = reading.value - 2 * last_.value + before_.value;
      const double median = 0.6745 * sigma;  // of the absolute value of a normal variable
      beyond_ += static_cast<double>((second.array().abs() > kScatter * median).count());
      count_ += 3;
      const double keep = count_ > kMemory ? kMemory / count_ : 1;
      count_ *= keep, beyond_ *= keep;
    }
    before_ = last_;
    last_ = reading;
  }
}

bool GyroNoiseTest::scatters() const { return count_ >= kFewest && beyond_ > 0.5 * count_; }

void ImageTest::add(double dt_s, std::size_t searched, std::size_t accepted, std::size_t unreliable) {
  const double keep = std::exp(-dt_s / kImageMemory_s);
  searched_ = keep * searched_ + static_cast<double>(searched);
  accepted_ = keep * accepted_ + static_cast<double>(accepted);
  unreliable_ = keep * unreliable_ + static_cast<double>(unreliable);
}

void ImageTest::add_health(double dt_s, bool lost, bool good_image) {
  losses_ *= std::exp(-dt_s / kLossMemory_s);
  const bool begins = lost && !lost_;
  if (begins) loss_counts_ = good_image;
  if (lost && loss_counts_) losses_ += begins ? 1 : dt_s / kLossLasts_s;
  lost_ = lost;
}

bool ImageTest::fails() const {
  const bool not_found = searched_ > kFewestSearches && accepted_ < kLeastFound * searched_;
  return (not_found && unreliable_ > kMostUnreliable) || losses_ > kMostLosses;
}

void SensorMonitor::add(const Evidence& evidence, double dt_s) {
  for (std::size_t k = 0; k < evidence.size(); ++k) systematic_[k].add(evidence[k], dt_s);
}

void SensorMonitor::reset() { systematic_ = {}; }

std::string SensorMonitor::suspect() const {
  if (options_.gyro.enabled && gyro_.scatters())
    return "inconsistent: gyro, its readings scatter more than 1.5 times as much as assumed";
  if (images_.fails()) return "inconsistent: images, landmarks are not found at their predicted pixels";
  const double lens = sigmas(kLensDistortion), legs = sigmas(kLegScale), plan = sigmas(kPlanScale);
  if (options_.vision.enabled && std::abs(lens) > options_.tracking.lens_bound)
    return by_sigmas("images, the assumed distortion of the lens is too ", lens, "large", "small");
  const bool scale_is_known = options_.accelerometer.enabled && options_.vision.enabled;
  if (options_.plan_velocity.enabled && scale_is_known && std::abs(legs) > options_.tracking.plan_bound)
    return by_sigmas("leg odometry, its distances are too ", legs, "long", "short");
  if (options_.plan_velocity.enabled && scale_is_known && std::abs(plan) > options_.tracking.plan_bound)
    return by_sigmas("plan, its distances are too ", plan, "long", "short");
  return "";
}

}  // namespace slam
