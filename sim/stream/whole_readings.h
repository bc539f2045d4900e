// Inertial readings at the sensor's own even rate, as other programs expect them: those that a frame had
// split are put together again.
#pragma once

#include <optional>
#include <vector>

#include "slam/observation.h"

namespace sim::stream {

/// A reading of the IMU at an instant: the middle of the interval over which it is the mean. That differs
/// from the value at this instant to second order only.
struct ImuReading {
  slam::Stamp t{0};
  Eigen::Vector3d gyro;                          ///< rad/s
  std::optional<Eigen::Vector3d> accelerometer;  ///< m/s²
};

/// Puts parts together until they make one period. After a gap in the readings it starts afresh.
class WholeReadings {
 public:
  explicit WholeReadings(double rate_hz);
  /// The readings that an observation completes, in order of time.
  std::vector<ImuReading> take(const slam::Observation& observation);

 private:
  void add(const slam::InertialSample& gyro, const slam::InertialSample* accelerometer,
           std::vector<ImuReading>& whole);

  slam::Stamp period_, begin_{0}, end_{0};
  Eigen::Vector3d gyro_ = Eigen::Vector3d::Zero(), accelerometer_ = Eigen::Vector3d::Zero();  // ∫ dt
};

}  // namespace sim::stream
