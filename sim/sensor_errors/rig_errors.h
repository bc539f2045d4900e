// Errors of the rig's further sensors: cameras, depth, lidars, IMUs and their clocks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/rig/rig.h"
#include "sim/sensor_errors/image_errors.h"
#include "sim/sensor_errors/motion_errors.h"
#include "slam/observation.h"

namespace sim::sensor_errors {

/// Applies the errors of each sensor to its readings, then shifts their stamps by the sensor's offset. Draws
/// are keyed by seed, the sensor's name and the true stamp: a further sensor changes no number of another.
class RigErrors {
 public:
  RigErrors(const std::vector<rig::RigSensor>& rig, std::uint64_t seed);

  /// Does not write to the images' pixels.
  void apply(std::vector<slam::RigReading>& readings);

 private:
  struct Sensor {
    rig::RigSensor is;
    std::string stream;
    ImageErrors image;
    InertialErrors gyro, accelerometer;
  };
  std::uint64_t seed_;
  std::vector<Sensor> sensors_;
};

/// The pixels of a depth image (CV_16UC1, mm, 0: none) within `reach` pixels of an occlusion edge, as
/// non-zero values of CV_8UC1. An edge is between two neighbors in a row or a column whose inverse depths
/// differ by more than 2 % and by more than three times the larger difference to their next neighbors on
/// either side: on a plane of any slant inverse depth is linear in the pixel, so that these are equal.
cv::Mat1b beside_edges(const cv::Mat1w& depth_mm, int reach);

}  // namespace sim::sensor_errors
