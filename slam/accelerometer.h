// The accelerometer as the input of the motion model: the change of the camera's mean velocity from one frame
// interval to the next, integrated from the specific forces in both.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "slam/observation.h"
#include "slam/options.h"
#include "slam/state.h"

namespace slam {

/// v̄⁺ − v̄ = R_WC increment_C + duration g, where v̄ is the mean velocity over a frame interval, R_WC the
/// orientation at the frame between the two intervals and g gravity.
struct VelocityIncrement {
  Eigen::Vector3d increment_C;  ///< m/s
  double duration_s;
  double sigma_m_s;  ///< per axis
};

/// Gyro and accelerometer readings of one frame interval (from, to].
struct InertialInterval {
  Stamp from{0}, to{0};
  std::vector<InertialSample> gyro, accelerometer;
};

/// Integration by parts gives v̄⁺ − v̄ = ∫(t₊ − t) a dt/Δ₊ over the later interval + ∫(t − t₋) a dt/Δ over the
/// earlier one. Here a is the acceleration of the chest, rotated by the gyro into the axes of the camera at
/// the frame between the intervals; the motion of the chest relative to the camera is subtracted.
/// gyro_bias_C: rad/s in C. Nothing where readings are missing or the intervals do not adjoin.
std::optional<VelocityIncrement> velocity_increment(const InertialInterval& earlier,
                                                    const InertialInterval& later,
                                                    const Eigen::Isometry3d& X_CG,
                                                    const Eigen::Vector3d& gyro_bias_C,
                                                    const Options& options);

}  // namespace slam
