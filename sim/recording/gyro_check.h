// Comparison of a gyro with the true rotation: clock, unit and axes.
#pragma once

#include "sim/files/trajectory_file.h"
#include "slam/observation.h"

namespace sim::recording {

/// A reading of a gyro.
struct TimedRotation {
  slam::Stamp t{0};
  Eigen::Vector3d value;  ///< rad/s
};

/// The axis of the truth that an axis of the gyro follows, 0 to 2, and its sign, 1 or -1.
struct FollowedAxis {
  int axis, sign;
  bool operator==(const FollowedAxis&) const = default;
};

struct GyroComparison {
  double late_s;                   ///< stamps of the gyro minus those of the truth; 0 without evidence
  double correlation, as_stamped;  ///< of the speeds of rotation, at this offset and at none
  double gain;                     ///< the gyro's speeds relative to those of the truth
  /// The axes of the truth that those of the gyro follow, if these are decisively others than their own.
  std::optional<std::array<FollowedAxis, 3>> axes = {};
  bool mirrored = false;  ///< no rotation of the body explains the gyro, but one of its mirror image does
  std::optional<double> turned_rad = {};  ///< angle between the axes of both, if it is decisively not 0
};

/// Compares a gyro with the truth of the first hour by their turns over 0.1 s, without bias; R_GT: from the
/// axes of the truth to the gyro's. An offset of at most 10 s, and other axes, need a log-likelihood ratio of
/// at least 20 over none; returns nothing unless the speeds correlate by at least 0.6.
std::optional<GyroComparison> compare_gyro(const std::vector<TimedRotation>& gyro,
                                           const std::vector<files::TumRow>& truth,
                                           const Eigen::Matrix3d& R_GT = Eigen::Matrix3d::Identity());

/// Returns "x, -y, z" for axes.
std::string axes_text(const std::array<FollowedAxis, 3>& axes);

}  // namespace sim::recording
