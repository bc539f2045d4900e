#include "slam/gyro.h"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

/// As in the paper, the rate at the frame is the last reading before it.
std::optional<MeanRate> last_rate(const std::vector<InertialSample>& gyro, Stamp from, Stamp to,
                                  const Eigen::Matrix3d& R_CG, double sigma) {
  if (gyro.empty() || gyro.back().end <= from || gyro.back().end > to) return std::nullopt;
  return MeanRate{R_CG * gyro.back().value, sigma};
}

}  // namespace

std::optional<MeanRate> mean_rate(const std::vector<InertialSample>& gyro, Stamp from, Stamp to,
                                  const Eigen::Matrix3d& R_CG, const Options& options) {
  if (options.gyro.readings == GyroReadings::last)
    return last_rate(gyro, from, to, R_CG, options.gyro.sigma_rad_s);
  const double dt = seconds(to - from);
  Eigen::Vector4d rotation(1, 0, 0, 0);
  double covered = 0;
  for (const InertialSample& sample : gyro) {
    const double part = seconds(std::min(sample.end, to) - std::max(sample.begin, from));
    if (part <= 0) continue;
    rotation = quaternion_product(rotation, quaternion_exp(sample.value * part));
    covered += part;
  }
  if (covered < 0.5 * dt) return std::nullopt;
  const double gap = std::max(0.0, dt - covered);
  const double sigma_gap = options.motion.sigma_angular_acceleration_rad_s2 * gap * gap / dt;
  const double sigma_readings = options.gyro.sigma_rad_s * std::sqrt(kReadingPeriod_s / covered);
  return MeanRate{R_CG * quaternion_log(rotation) / covered, std::hypot(sigma_readings, sigma_gap)};
}

Measurement measure_rate(const RobotVector& x, const MeanRate& rate) {
  Measurement m(3);
  m.innovation.head<3>() = rate.w_C - x.segment<3>(kRate) - x.segment<3>(kGyroBias);
  m.H_robot.middleCols(kRate, 3).setIdentity();
  m.H_robot.middleCols(kGyroBias, 3).setIdentity();
  m.R.diagonal().setConstant(rate.sigma_rad_s * rate.sigma_rad_s);
  return m;
}

Measurement measure_rest(const RobotVector& x, double sigma_rad_s) {
  Measurement m(3);
  m.innovation.head<3>() = -x.segment<3>(kRate);
  m.H_robot.middleCols(kRate, 3).setIdentity();
  m.R.diagonal().setConstant(sigma_rad_s * sigma_rad_s);
  return m;
}

}  // namespace slam
