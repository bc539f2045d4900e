// Gyro and accelerometer: the gyro's readings of a frame interval are one measurement of the camera's mean
// rate, the accelerometer's are the input of the motion model.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "slam/measurement.h"
#include "slam/observation.h"
#include "slam/options.h"
#include "slam/state.h"

namespace slam {

/// Mean angular rate of the camera over one frame interval, rad/s in C, and its standard deviation per axis.
struct MeanRate {
  Eigen::Vector3d w_C;
  double sigma_rad_s;
};

/// Log(Π Exp(w_i dt_i))/Δt over the readings inside (from, to], expressed in C. The standard deviation is
/// that of one reading, reduced by averaging; for the part of the interval without readings it grows by the
/// change of rate that the motion model allows. Nothing if less than half the interval is covered. With
/// GyroReadings::last the result is the last reading.
std::optional<MeanRate> mean_rate(const std::vector<InertialSample>& gyro, Stamp from, Stamp to,
                                  const Eigen::Matrix3d& R_CG, const Options& options);

/// The measurement h = ω + bias of the camera's rate (Stasse et al. 2006, section IV-C; Davison et al.
/// 2007).
Measurement measure_rate(const RobotVector& x, const MeanRate& rate);

/// The measurement h = ω of a camera that stands still, as 0. sigma_rad_s: of the angular velocity of a frame
/// interval.
Measurement measure_rest(const RobotVector& x, double sigma_rad_s);

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
/// gyro_bias_C: rad/s in C. Nothing if readings are missing or the intervals do not adjoin.
std::optional<VelocityIncrement> velocity_increment(const InertialInterval& earlier,
                                                    const InertialInterval& later,
                                                    const Eigen::Isometry3d& X_CG,
                                                    const Eigen::Vector3d& gyro_bias_C,
                                                    const Options& options);

}  // namespace slam
