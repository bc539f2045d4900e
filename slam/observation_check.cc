#include "slam/observation_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "slam/patch.h"

namespace slam {
namespace {

bool is_finite(const PlannedMotion& plan) {
  return plan.X_PC.matrix().allFinite() && plan.v_PC_C.allFinite() && plan.w_PC_C.allFinite() &&
         plan.p_CF.allFinite() &&
         (!plan.legs || (plan.legs->X_OC.matrix().allFinite() && plan.legs->p_CS.allFinite()));
}

/// Standard deviation of the grey values in every fourth row.
double contrast(const cv::Mat& image) {
  std::int64_t sum = 0, square = 0, count = 0;
  for (int row = 0; row < image.rows; row += 4) {
    const uchar* grey = image.ptr<uchar>(row);
    for (int column = 0; column < image.cols; ++column) {
      sum += grey[column];
      square += grey[column] * grey[column];
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

}  // namespace

std::string malformation(const Observation& o, const CameraIntrinsics& camera) {
  if (!o.image.empty() &&
      (o.image.type() != CV_8UC1 || o.image.cols != camera.width_px || o.image.rows != camera.height_px))
    return "its image is not 8-bit grey of the camera's size";
  for (const auto* samples : {&o.gyro, &o.accelerometer})
    for (const InertialSample& sample : *samples)
      if (!sample.value.allFinite() || sample.end < sample.begin) return "an inertial reading is not finite";
  if (o.plan && !is_finite(*o.plan)) return "its plan is not finite";
  return "";
}

bool stands_still(const Observation& o, const std::optional<PlannedVelocity>& planned,
                  const Options& options) {
  return options.plan_velocity.enabled && planned && planned->velocity.norm() < kStandingSpeed &&
         planned->rate.norm() < kStandingSpeed && options.gyro.enabled && !o.gyro.empty() &&
         mean_gyro_rad_s(o.gyro) < kStill_rad_s;
}

/// A camera at rest shows the same scene twice, so that differences all over the image are its noise.
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

}  // namespace slam
