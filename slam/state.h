// What the filter believes: layout of the state vector, its mean and its covariance.
#pragma once

#include <Eigen/Geometry>

#include "slam/rotation.h"

namespace slam {

// Where each part of the robot's state begins; the landmarks' parameters follow at kRobot.
inline constexpr int kPosition = 0;            ///< r, p_WC in m
inline constexpr int kOrientation = 3;         ///< q_WC as (w, x, y, z)
inline constexpr int kVelocity = 7;            ///< mean velocity over the last frame interval, m/s in W
inline constexpr int kRate = 10;               ///< mean w_WC_C over the last frame interval, rad/s
inline constexpr int kCamera = 13;             ///< MonoSLAM's camera state ends here
inline constexpr int kGyroBias = 13;           ///< rad/s, axes C
inline constexpr int kSlip = 16;               ///< planned minus true velocity, m/s, axes C
inline constexpr int kAccelerometerBias = 19;  ///< m/s², axes C
inline constexpr int kSwayVelocity = 22;       ///< of swaying, planned minus true, m/s, axes C
inline constexpr int kSway = 25;               ///< how far that has come, m, axes C
inline constexpr int kStride =
    28;  ///< planned strides are longer by this part, and turned aside by this angle
inline constexpr int kRobot = 30;

using RobotVector = Eigen::Matrix<double, kRobot, 1>;
using RobotMatrix = Eigen::Matrix<double, kRobot, kRobot>;

/// A landmark's part of the state vector, and a derivative of it, without the heap.
using Parameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;
using ParameterJacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

/// Mean and covariance. Storage grows ahead of need; the first size rows and columns are in use, and of the
/// covariance only the lower triangle: what lies above the diagonal means nothing.
/// null_yaw is the direction in which the whole world may turn about the vertical without any measurement
/// noticing.
struct State {
  int size = kRobot;
  Eigen::VectorXd storage_x = Eigen::VectorXd::Zero(kRobot), storage_null = Eigen::VectorXd::Zero(kRobot);
  Eigen::MatrixXd storage_P = Eigen::MatrixXd::Zero(kRobot, kRobot);

  auto x() const { return storage_x.head(size); }
  /// The whole covariance, both triangles.
  Eigen::MatrixXd P() const { return storage_P.topLeftCorner(size, size).selfadjointView<Eigen::Lower>(); }
  /// The covariance of Count parameters from `at` on, both triangles.
  template <int Count>
  Eigen::Matrix<double, Count, Count> marginal(int at) const {
    return storage_P.block<Count, Count>(at, at).template selfadjointView<Eigen::Lower>();
  }
  auto null_yaw() const { return storage_null.head(size); }

  Eigen::Vector3d position() const { return storage_x.segment<3>(kPosition); }
  Eigen::Vector4d orientation() const { return storage_x.segment<4>(kOrientation); }
  Eigen::Vector3d velocity() const { return storage_x.segment<3>(kVelocity); }
  Eigen::Vector3d rate() const { return storage_x.segment<3>(kRate); }
  Eigen::Isometry3d X_WC() const;
};

/// The robot's part of the unobservable turn about the vertical, at the given mean.
RobotVector robot_null_yaw(const RobotVector& x);

}  // namespace slam
