// The chest IMU: what gyro and accelerometer give over an interval, from the true motion at its two ends.
#pragma once

#include <Eigen/Geometry>
#include <chrono>

namespace sim::physics {

/// Attitude and velocity of the IMU (axes G) at one instant.
struct ImuState {
  std::chrono::nanoseconds t{0};
  Eigen::Matrix3d R_WG = Eigen::Matrix3d::Identity();
  Eigen::Vector3d v_WG = Eigen::Vector3d::Zero();  ///< m/s in W
};

/// Means over (begin, end], in the axes G at half of the turn.
struct ImuReading {
  std::chrono::nanoseconds begin{0}, end{0};
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();            ///< rad/s
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();  ///< m/s², +g up at rest
};

/// The reading that integrates exactly from one state to the next, like an IMU with internal sculling
/// compensation: gyro = Log(R_0ᵀ R_1)/dt, specific force = R_½ᵀ ((v_1 − v_0)/dt − g), R_½ = R_0 Exp(½
/// Log(R_0ᵀ R_1)). Empty interval: the reading is zero. gravity: m/s² in W.
ImuReading reading_between(const ImuState& from, const ImuState& to, const Eigen::Vector3d& gravity);

}  // namespace sim::physics
