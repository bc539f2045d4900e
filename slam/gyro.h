// The gyro: the readings of a frame interval are composed into one measurement of the camera's mean rate.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "slam/kalman.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace slam {

/// Mean angular rate of the camera over one frame interval, rad/s in C, and its standard deviation per axis.
struct MeanRate {
  Eigen::Vector3d w_C;
  double sigma_rad_s;
};

/// Log(Π Exp(w_i dt_i))/Δt over the readings inside (from, to], expressed in C. The standard deviation is
/// that of one reading, reduced by averaging; for the part of the interval without readings it grows by the
/// change of rate that the motion model allows. Nothing where less than half the interval is covered. With
/// GyroReadings::last the result is the last reading.
std::optional<MeanRate> mean_rate(const std::vector<InertialSample>& gyro, Stamp from, Stamp to,
                                  const Eigen::Matrix3d& R_CG, const Options& options);

/// The measurement h = ω + bias of the camera's rate (Stasse et al. 2006, section IV-C; Davison et al.
/// 2007).
Measurement measure_rate(const RobotVector& x, const MeanRate& rate);

/// The measurement h = ω of a camera that stands still, as 0. sigma_rad_s: of the angular velocity of a frame
/// interval.
Measurement measure_rest(const RobotVector& x, double sigma_rad_s);

}  // namespace slam
