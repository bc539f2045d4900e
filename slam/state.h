// The state of the filter: the layout of the state vector, its mean and its covariance.
#pragma once

#include <Eigen/Geometry>

#include "slam/rotation.h"

namespace slam {

// The first index of each part of the robot's state; the landmarks' parameters start at kRobot.
inline constexpr int kPosition = 0;            ///< r = p_WC, m
inline constexpr int kOrientation = 3;         ///< q_WC as (w, x, y, z)
inline constexpr int kVelocity = 7;            ///< mean velocity over the last frame interval, m/s in W
inline constexpr int kRate = 10;               ///< mean w_WC_C over the last frame interval, rad/s
inline constexpr int kCamera = 13;             ///< size of MonoSLAM's camera state, which ends here
inline constexpr int kGyroBias = 13;           ///< rad/s, axes C
inline constexpr int kHeightError = 16;        ///< lasting error of the height, measured minus true, m
inline constexpr int kSwayScale = 17;          ///< relative errors of the sway along x and z of C
inline constexpr int kAccelerometerBias = 19;  ///< m/s², axes C
inline constexpr int kSwayVelocity = 22;  ///< velocity of unplanned swaying, planned minus true, m/s in C
inline constexpr int kSwayPosition = 25;  ///< displacement by unplanned swaying, m in C
inline constexpr int kStrideError = 28;   ///< relative error of the strides' length, and their angle, rad
inline constexpr int kLegError = 30;      ///< error of leg odometry's position, measured minus true, m in C
inline constexpr int kPreviousLegError = 33;  ///< the same in the previous frame
inline constexpr int kRobot = 36;

// Systematic errors that the innovations reveal (monitors.h), all relative.
inline constexpr int kPlanScale = 0;       ///< error of the planned distances
inline constexpr int kLensDistortion = 1;  ///< error of the lens distortion in the calibration
inline constexpr int kLegScale = 2;        ///< error of the distances from leg odometry
inline constexpr int kSystematicErrors = 3;

using RobotVector = Eigen::Matrix<double, kRobot, 1>;
using RobotMatrix = Eigen::Matrix<double, kRobot, kRobot>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The parameters of one landmark and their derivatives, of bounded size, so that they need no heap memory.
using Parameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;
using ParameterJacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

/// The derivative of values with respect to the systematic errors, one row for each value.
using Sensitivity = Eigen::Matrix<double, Eigen::Dynamic, kSystematicErrors>;

/// Evidence of a systematic error δ in innovations ν: with u = ∂ν/∂δ, the sums of uᵀS⁻¹ν and of uᵀS⁻¹u. The
/// first sum has a mean of δ times the second, and the second as its variance.
struct SystematicEvidence {
  double score = 0, information = 0;
};

/// Mean and covariance of the robot.
struct RobotState {
  RobotVector x;
  RobotMatrix P;
};

/// Mean and covariance of robot and landmarks. The storage is larger than needed, so that it rarely grows:
/// the first `size` rows and columns are in use. Only the lower triangle of the covariance is kept; the rest
/// is undefined. null_yaw is the change of the state when the whole world turns about the vertical, which no
/// measurement can observe. sensitivity is the derivative of the mean with respect to the systematic errors,
/// one column for each.
struct State {
  int size = kRobot;
  Eigen::VectorXd storage_x = Eigen::VectorXd::Zero(kRobot), storage_null = Eigen::VectorXd::Zero(kRobot);
  Sensitivity storage_sensitivity = Sensitivity::Zero(kRobot, kSystematicErrors);
  Eigen::MatrixXd storage_P = Eigen::MatrixXd::Zero(kRobot, kRobot);

  auto x() const { return storage_x.head(size); }
  /// The whole symmetric covariance.
  Eigen::MatrixXd P() const { return storage_P.topLeftCorner(size, size).selfadjointView<Eigen::Lower>(); }
  /// The symmetric covariance of the Count parameters starting at index `at`.
  template <int Count>
  Eigen::Matrix<double, Count, Count> marginal(int at) const {
    return storage_P.block<Count, Count>(at, at).template selfadjointView<Eigen::Lower>();
  }
  auto null_yaw() const { return storage_null.head(size); }

  RobotVector robot() const { return storage_x.head<kRobot>(); }
  Eigen::Vector3d position() const { return storage_x.segment<3>(kPosition); }
  Eigen::Vector4d orientation() const { return storage_x.segment<4>(kOrientation); }
  Eigen::Vector3d velocity() const { return storage_x.segment<3>(kVelocity); }
  Eigen::Isometry3d X_WC() const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = rotation_matrix(orientation());
    X.translation() = position();
    return X;
  }
};

}  // namespace slam
