// The self-check of a run. A run whose ideal gyro and accelerometer disagree with its truth is not scored.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "sim/recording/recording.h"
#include "slam/observation.h"

namespace sim::live {

/// Integrates gyro and accelerometer with the trapezoidal rule (which is not the inverse of the readings'
/// formula) twice: using all readings, and using every second one. The difference between the two shows the
/// error due to the step length, which grows with the robot's vibration. An integration of 30 s starts at the
/// truth every 10 s. All of them restart after a reading of more than 50 m/s², because its mean does not show
/// how an impact was distributed over time.
struct InertialCheck {
  explicit InertialCheck(const recording::TrueMotion& start) : integrations{{start, start}} {}

  /// Adds one reading of each sensor and the true motion at its end.
  void add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
           const recording::TrueMotion& end);

  struct Integration {
    recording::TrueMotion fine, coarse;  ///< t: at the start
  };
  struct Error {
    double worst = 0, by_step = 0;
  };
  std::deque<Integration> integrations;
  std::optional<std::pair<Eigen::Vector3d, Eigen::Vector3d>> half;  ///< first readings of a pair
  slam::Stamp longest{0};                                           ///< duration of the longest integration
  Error position_m, yaw_deg;

  /// Describes the disagreement, if there is any.
  std::optional<std::string> complaint() const;
  /// The figures, for the recording's self_check.json.
  std::string json() const;
};

/// Largest errors of a run's ideal sensors, beyond those due to the step length.
inline constexpr double kInertialPosition_m = 0.01, kInertialYaw_deg = 0.01;

}  // namespace sim::live
