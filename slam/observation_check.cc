#include "slam/observation_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "slam/patch.h"

namespace slam {
namespace {

bool is_finite(const PlannedMotion& plan) {
  return plan.X_PC.matrix().allFinite() && plan.v_PC_C.allFinite() && plan.w_PC_C.allFinite() &&
         plan.p_CF.allFinite();
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

std::string ImageCheck::defect(const cv::Mat& image) {
  const bool frozen =
      !previous_.empty() && std::equal(image.begin<uchar>(), image.end<uchar>(), previous_.begin<uchar>());
  image.copyTo(previous_);
  if (contrast(image) < kFlatContrast) return "the image is flat";
  if (frozen) return "the image is the last one again";
  return "";
}

}  // namespace slam
