// Poses and trajectories for tests: upright ones, and deterministic ones without symmetry.
#pragma once

#include <cmath>

#include "sim/score/trajectory.h"

namespace sim::score {

inline constexpr Stamp kFrame{33'333'333};

/// A number in (−1, 1) that looks like no other's.
inline double scatter(int i, int j) {
  const double x = std::sin(12.9898 * i + 78.233 * j) * 43758.5453;
  return 2 * (x - std::floor(x)) - 1;
}

inline Eigen::Vector3d scattered(int i, int j) {
  return {scatter(i, j), scatter(i, j + 1), scatter(i, j + 2)};
}

inline Eigen::Isometry3d scattered_pose(int i, int j, double size = 1) {
  const Eigen::Vector3d turn = size * scattered(i, j);
  Eigen::Isometry3d X(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  X.translation() = size * scattered(i, j + 3);
  return X;
}

/// An upright pose at a place (m), turned about z by `yaw_rad`.
inline Eigen::Isometry3d upright(double x, double y, double z, double yaw_rad = 0) {
  Eigen::Isometry3d X(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
  X.translation() = Eigen::Vector3d(x, y, z);
  return X;
}

/// A curve in space with turning poses.
inline Trajectory curve(int count) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double s = 0.1 * i;
    Eigen::Isometry3d X(Eigen::AngleAxisd(s, Eigen::Vector3d(0.1, 0.2, 1).normalized()));
    X.translation() = Eigen::Vector3d(std::cos(s), std::sin(s), 0.3 * std::sin(2 * s));
    trajectory.push_back({i * kFrame, X});
  }
  return trajectory;
}

/// Pairs of a curve with a scattered version of itself.
inline std::vector<PosePair> noisy_pairs(int count, double size) {
  std::vector<PosePair> pairs;
  for (const TimedPose& pose : curve(count)) {
    const Eigen::Isometry3d error = scattered_pose(static_cast<int>(pairs.size()) + 1, 1, size);
    pairs.push_back({pose.t, pose.X, pose.X * error});
  }
  return pairs;
}

}  // namespace sim::score
