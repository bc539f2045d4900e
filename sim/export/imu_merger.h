// Readings in their exported form, and the merger of those of an IMU that a frame had split.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "slam/observation.h"

namespace sim::exports {

/// A reading in its exported form: the image of the exported camera; one of an IMU is the mean of an
/// interval, stamped in its middle. It differs from the value at that instant by terms of second order in the
/// length of the interval.
struct ExportedReading : slam::RigReading {
  bool has_acceleration = true;
};

/// Merges consecutive parts until they cover one period. After a gap in the readings it starts anew.
class ImuMerger {
 public:
  explicit ImuMerger(double rate_hz) : period_(std::llround(1e9 / rate_hz)) {}
  /// Returns the readings that an observation completes, in order of time.
  std::vector<ExportedReading> merge(const slam::Observation& observation) {
    std::vector<ExportedReading> merged;
    const bool both = observation.accelerometer.size() == observation.gyro.size();
    const auto start_at = [this](slam::Stamp t) {
      begin_ = t;
      gyro_.setZero();
      accelerometer_.setZero();
    };
    for (std::size_t i = 0; i < observation.gyro.size(); ++i) {
      const slam::InertialSample& gyro = observation.gyro[i];
      if (gyro.begin != end_) start_at(gyro.begin);
      const double dt = slam::seconds(gyro.end - gyro.begin);
      gyro_ += dt * gyro.value;
      if (both) accelerometer_ += dt * observation.accelerometer[i].value;
      end_ = gyro.end;
      if (end_ - begin_ < period_) continue;
      const double duration = slam::seconds(end_ - begin_);
      ExportedReading& reading = merged.emplace_back();
      reading.t = begin_ + (end_ - begin_) / 2, reading.gyro = gyro_ / duration;
      reading.accelerometer = accelerometer_ / duration, reading.has_acceleration = both;
      start_at(end_);
    }
    return merged;
  }

 private:
  slam::Stamp period_, begin_{0}, end_{0};
  Eigen::Vector3d gyro_ = Eigen::Vector3d::Zero(), accelerometer_ = Eigen::Vector3d::Zero();  // ∫ dt
};

}  // namespace sim::exports
