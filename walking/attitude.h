// The vertical estimated from gyro and accelerometer: the complementary filter of Mahony et al. 2008.
#pragma once

#include <Eigen/Core>

namespace walking {

/// Gains of the attitude filter.
struct AttitudeOptions {
  bool enabled = true;
  double accelerometer_gain_per_s = 0.15;
  double bias_gain_per_s2 = 0.004;

  static void keys(auto&& key) {
    value<&AttitudeOptions::enabled>(
        key,
        "whether the tilt of the waist is estimated from gyro and accelerometer; otherwise it counts "
        "as upright");
    number<&AttitudeOptions::accelerometer_gain_per_s>(
        key, 0, 1e6, "rate at which the estimated vertical is corrected towards the accelerometer's");
    number<&AttitudeOptions::bias_gain_per_s2>(
        key, 0, 1e6, "gain with which the attitude filter estimates the gyro's bias");
  }
};

/// Tracks the vertical in the axes of the IMU. The heading is not observable.
class Attitude {
 public:
  /// Begins with `up`, the vertical in the IMU's axes (need not be unit).
  explicit Attitude(const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ(),
                    const AttitudeOptions& options = {});

  /// One interval: mean angular velocity (rad/s) and specific force (m/s²), both in IMU axes, over dt (s).
  /// motion: the acceleration that the robot is known to carry out itself, same axes (m/s²); it is taken off
  /// the specific force, what is left being gravity's.
  void update(const Eigen::Vector3d& gyro, const Eigen::Vector3d& specific_force,
              const Eigen::Vector3d& motion, double dt);

  const Eigen::Vector3d& up() const { return up_; }  ///< unit vector, IMU axes
  /// Of the gyro, rad/s; its vertical part is not observable.
  const Eigen::Vector3d& bias() const { return bias_; }

 private:
  AttitudeOptions options_;
  Eigen::Vector3d up_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
};

}  // namespace walking
