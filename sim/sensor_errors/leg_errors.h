// Errors of leg odometry on its way to the filter.
#pragma once

#include <cstdint>
#include <optional>

#include "slam/observation.h"

namespace sim::sensor_errors {

/// Takes the leg odometry of one frame after another, in the order of their stamps. sigma_m: white noise of
/// each frame's position, per axis, drawn by seed and stamp. scale_fraction: how much longer the distances
/// are than they should be.
class LegErrors {
 public:
  LegErrors(double sigma_m, double scale_fraction, std::uint64_t seed)
      : sigma_m_(sigma_m), scale_fraction_(scale_fraction), seed_(seed) {}
  void apply(slam::LegMotion& legs, slam::Stamp t);

 private:
  double sigma_m_, scale_fraction_;
  std::uint64_t seed_;
  std::optional<Eigen::Vector3d> first_p_OC_;
};

}  // namespace sim::sensor_errors
