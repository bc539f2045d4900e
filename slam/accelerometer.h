// The accelerometer folded into the motion model: how the camera's mean velocity changes from one frame
// interval to the next, from the specific forces of both.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "slam/observation.h"
#include "slam/options.h"
#include "slam/state.h"

namespace slam {

/// v̄⁺ − v̄ = R_WC impulse_C + duration g, where v̄ is the mean velocity over a frame interval, R_WC the
/// attitude at the frame between the two intervals and g gravity. Standard deviation per axis, m/s.
struct Impulse {
  Eigen::Vector3d impulse_C;
  double duration_s;
  double sigma_m_s;
};

/// Gyro and accelerometer readings of one frame interval (from, to].
struct InertialInterval {
  Stamp from{0}, to{0};
  std::vector<InertialSample> gyro, accelerometer;
};

/// By parts, v̄⁺ − v̄ = ∫(t₊ − t) a dt/Δ₊ over the later interval + ∫(t − t₋) a dt/Δ over the earlier one, with
/// a the acceleration of the chest, turned by the gyro into the axes of the camera at the frame between; what
/// the lever from camera to chest does meanwhile is taken off. gyro_bias_C in the camera's axes. Nothing
/// where readings are missing.
std::optional<Impulse> mean_velocity_change(const InertialInterval& earlier, const InertialInterval& later,
                                            const Eigen::Isometry3d& X_CG, const Eigen::Vector3d& gyro_bias_C,
                                            const Options& options);

}  // namespace slam
