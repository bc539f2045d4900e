// IMU readings at the constant rate of the sensor, which other programs expect: readings that a frame had
// split are merged.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "slam/observation.h"

namespace sim::exports {

/// The mean of an interval, stamped in its middle. It differs from the value at that instant by terms of
/// second order in the length of the interval.
struct ImuReading {
  slam::Stamp t{0};
  Eigen::Vector3d gyro;                          ///< rad/s
  std::optional<Eigen::Vector3d> accelerometer;  ///< m/s²
};

/// Merges consecutive parts until they cover one period. After a gap in the readings it starts anew.
class ImuMerger {
 public:
  explicit ImuMerger(double rate_hz) : period_(std::llround(1e9 / rate_hz)) {}
  /// The readings that an observation completes, in order of time.
  std::vector<ImuReading> merge(const slam::Observation& observation) {
    std::vector<ImuReading> merged;
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
      merged.push_back({begin_ + (end_ - begin_) / 2, gyro_ / duration, std::nullopt});
      if (both) merged.back().accelerometer = accelerometer_ / duration;
      start_at(end_);
    }
    return merged;
  }

 private:
  slam::Stamp period_, begin_{0}, end_{0};
  Eigen::Vector3d gyro_ = Eigen::Vector3d::Zero(), accelerometer_ = Eigen::Vector3d::Zero();  // ∫ dt
};

}  // namespace sim::exports
