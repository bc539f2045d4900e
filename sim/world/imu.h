// The chest IMU: what gyro and accelerometer give over an interval, from the true motion at its two ends.
#pragma once

#include <Eigen/Geometry>
#include <chrono>

namespace sim::world {

/// Attitude and velocity of the IMU (axes G) at one instant.
struct ImuState {
  std::chrono::nanoseconds t{0};
  Eigen::Matrix3d R_WG = Eigen::Matrix3d::Identity();
  Eigen::Vector3d v_WG = Eigen::Vector3d::Zero();  ///< m/s in W
};

/// Means over (begin, end], in the axes G has at `begin`.
struct ImuReading {
  std::chrono::nanoseconds begin{0}, end{0};
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();            ///< rad/s
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();  ///< m/s², +g up at rest
};

/// The reading whose integration leads exactly from one state to the next:
/// gyro = Log(R_0ᵀ R_1)/dt, specific force = R_0ᵀ ((v_1 − v_0)/dt − g). Empty interval: the reading is zero.
/// gravity: m/s² in W, (0, 0, −9.81).
ImuReading reading_between(const ImuState& from, const ImuState& to, const Eigen::Vector3d& gravity);

}  // namespace sim::world
