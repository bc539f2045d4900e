#include "slam/inertial.h"

#include <algorithm>
#include <cmath>

#include "slam/rotation.h"

namespace slam {
namespace {

/// As in the paper, the rate at the frame is the last reading before it.
std::optional<MeanRate> last_rate(const std::vector<InertialSample>& gyro, Stamp from, Stamp to,
                                  const Eigen::Matrix3d& R_CG, double sigma) {
  if (gyro.empty() || gyro.back().end <= from || gyro.back().end > to) return std::nullopt;
  return MeanRate{R_CG * gyro.back().value, sigma};
}

constexpr double kLongestGap_s = 0.001;
constexpr double kFrameSigma_m_s2 =
    0.1;  // of the difference between the accelerations of head and chest in a frame

/// The orientation of the chest relative to that at the start of the interval, integrated from the gyro.
class GyroIntegration {
 public:
  GyroIntegration(const InertialInterval& interval, const Eigen::Vector3d& bias_G)
      : interval_(interval), bias_G_(bias_G) {}

  /// The times of successive calls must rise.
  const Eigen::Vector4d& until(Stamp t) {
    for (; next_ < interval_.gyro.size(); ++next_) {
      const InertialSample& sample = interval_.gyro[next_];
      const Stamp end = std::min(t, sample.end), begin = std::max(now_, sample.begin);
      if (end > begin)
        q_ = quaternion_product(q_, quaternion_exp((sample.value - bias_G_) * seconds(end - begin)));
      if (sample.end > t) break;
    }
    now_ = std::max(now_, t);
    return q_;
  }

 private:
  const InertialInterval& interval_;
  Eigen::Vector3d bias_G_;
  std::size_t next_ = 0;
  Stamp now_{-1};
  Eigen::Vector4d q_{1, 0, 0, 0};
};

bool covered(const std::vector<InertialSample>& samples, Stamp from, Stamp to) {
  double sum = 0;
  for (const InertialSample& s : samples)
    sum += std::max(0.0, seconds(std::min(s.end, to) - std::max(s.begin, from)));
  return sum > seconds(to - from) - kLongestGap_s;
}

/// ∫ weight · specific force dt over an interval, in the axes of the chest at its start, and the rotation of
/// the chest over it. The weight rises from 0 to 1 or falls from 1 to 0.
struct WeightedIntegral {
  Eigen::Vector3d force_G = Eigen::Vector3d::Zero();
  Eigen::Vector4d rotation{1, 0, 0, 0};
  double squares = 0;  ///< Σ weight² dt · kReadingPeriod_s
};

WeightedIntegral integrate(const InertialInterval& interval, const Eigen::Vector3d& bias_G, bool rising) {
  WeightedIntegral sum;
  GyroIntegration orientation(interval, bias_G);
  const double duration = seconds(interval.to - interval.from);
  for (const InertialSample& sample : interval.accelerometer) {
    const Stamp begin = std::max(sample.begin, interval.from), end = std::min(sample.end, interval.to);
    if (end <= begin) continue;
    const Stamp middle = begin + (end - begin) / 2;
    const double into = seconds(middle - interval.from) / duration;
    const double dt = seconds(end - begin), weight = rising ? into : 1 - into;
    sum.force_G += weight * dt * (rotation_matrix(orientation.until(middle)) * sample.value);
    sum.squares += weight * weight * dt * kReadingPeriod_s;
  }
  sum.rotation = orientation.until(interval.to);
  return sum;
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

std::optional<VelocityIncrement> velocity_increment(const InertialInterval& earlier,
                                                    const InertialInterval& later,
                                                    const Eigen::Isometry3d& X_CG,
                                                    const Eigen::Vector3d& gyro_bias_C,
                                                    const Options& options) {
  for (const InertialInterval* i : {&earlier, &later})
    if (i->to <= i->from || !covered(i->accelerometer, i->from, i->to) || !covered(i->gyro, i->from, i->to))
      return std::nullopt;
  if (earlier.to != later.from) return std::nullopt;
  const Eigen::Matrix3d R_CG = X_CG.linear();
  const Eigen::Vector3d bias_G = R_CG.transpose() * gyro_bias_C;
  const WeightedIntegral before = integrate(earlier, bias_G, true), after = integrate(later, bias_G, false);
  const Eigen::Matrix3d back = rotation_matrix(before.rotation).transpose(),
                        ahead = rotation_matrix(after.rotation);

  const double d0 = seconds(earlier.to - earlier.from), d1 = seconds(later.to - later.from);
  const Eigen::Vector3d lever_G = R_CG.transpose() * X_CG.translation();
  const Eigen::Vector3d swing_G = (ahead * lever_G - lever_G) / d1 - (lever_G - back * lever_G) / d0;
  VelocityIncrement increment;
  increment.increment_C = R_CG * (back * before.force_G + after.force_G - swing_G);
  increment.duration_s = (d0 + d1) / 2;
  const double rate_sigma = options.gyro.sigma_rad_s * std::sqrt(kReadingPeriod_s * (1 / d0 + 1 / d1));
  const double force = options.accelerometer.sigma_m_s2 * std::sqrt(before.squares + after.squares);
  increment.sigma_m_s =
      std::hypot(force, rate_sigma * lever_G.norm(), kFrameSigma_m_s2 * increment.duration_s);
  return increment;
}

}  // namespace slam
