// The gyro: all readings of a frame interval composed into one mean rate of the camera, measured as ω.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "slam/kalman.h"
#include "slam/observation.h"
#include "slam/options.h"

namespace slam {

inline constexpr double kReadingPeriod_s =
    0.005;  ///< that the standard deviation of "one reading" is meant for

/// Mean angular rate of the camera over one frame interval, rad/s in C, and its standard deviation per axis.
struct MeanRate {
  Eigen::Vector3d w_C;
  double sigma_rad_s;
};

/// Log(Π Exp(w_i dt_i))/Δt over the readings inside (from, to], turned into the camera's axes. σ is that of
/// one reading, reduced by averaging; the part of the interval without readings adds what the rate may have
/// changed meanwhile. Nothing where less than half the interval is covered. With GyroReadings::last the last
/// reading alone, as it is.
std::optional<MeanRate> mean_rate(const std::vector<InertialSample>& gyro, Stamp from, Stamp to,
                                  const Eigen::Matrix3d& R_CG, const Options& options);

/// h = ω + bias (Stasse et al. 2006, section III-C; Davison et al. 2007).
Measurement measure_rate(const RobotVector& x, const MeanRate& rate);

}  // namespace slam
