// Keeps the robot on its feet from what its own sensors say: attitude, ankle forces, encoders. No true pose comes here.
#pragma once

#include <Eigen/Geometry>

#include "walking/plan.h"

namespace walking {

/// Force (N) and torque (N·m) that the ground exerts on a foot, in the axes of the sole, about the sole point.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
};

/// What the robot's own sensors say at a tick.
struct Felt {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();           ///< rad/s, chest IMU axes, mean over the last 5 ms
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  ///< m/s², specific force, chest IMU axes
  Wrench left, right;
  JointVector q = JointVector::Zero();                      ///< encoders, rad
};

/// Where the stabiliser wants waist and soles, in P, for the inverse kinematics.
struct Posture {
  Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity(), X_PL = Eigen::Isometry3d::Identity(),
                    X_PR = Eigen::Isometry3d::Identity();
};

}  // namespace walking
