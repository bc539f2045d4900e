// IMU readings at the constant rate of the sensor, which other programs expect: readings that a frame had
// split are merged.
#pragma once

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
  explicit ImuMerger(double rate_hz);
  /// The readings that an observation completes, in order of time.
  std::vector<ImuReading> merge(const slam::Observation& observation);

 private:
  void add(const slam::InertialSample& gyro, const slam::InertialSample* accelerometer,
           std::vector<ImuReading>& merged);

  slam::Stamp period_, begin_{0}, end_{0};
  Eigen::Vector3d gyro_ = Eigen::Vector3d::Zero(), accelerometer_ = Eigen::Vector3d::Zero();  // ∫ dt
};

}  // namespace sim::exports
