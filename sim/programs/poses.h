// Poses in messages: a structure of rotation[9], by rows, and translation_m[3].
#pragma once

#include <Eigen/Geometry>
#include <algorithm>

namespace sim::programs {

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

inline void copy(const Eigen::Vector3d& from, double* to) { std::copy_n(from.data(), 3, to); }

template <class Pose>
Pose pose_of(const Eigen::Isometry3d& X) {
  Pose pose{};
  Eigen::Map<RowMajor3d>(pose.rotation) = X.linear();
  copy(X.translation(), pose.translation_m);
  return pose;
}

Eigen::Isometry3d isometry_of(const auto& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Map<const RowMajor3d>(pose.rotation);
  X.translation() = Eigen::Map<const Eigen::Vector3d>(pose.translation_m);
  return X;
}

}  // namespace sim::programs
