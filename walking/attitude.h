// Which way is up, from gyro and accelerometer alone: the complementary filter of Mahony et al. 2008 on the
// vertical.
#pragma once

#include <Eigen/Core>

namespace walking {

/// Gains of the attitude filter.
struct AttitudeOptions {
  bool enabled = true;  ///< false: who asks takes the body to be upright
  double accelerometer_gain_per_s = 0.15;  ///< how fast the gyro's drift is pulled back to the felt vertical
  double bias_gain_per_s2 = 0.004;         ///< how fast a gyro bias is learnt
};

/// Tracks the vertical in the axes of the IMU. Heading stays unknown, as it must without a compass.
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
  const Eigen::Vector3d& bias() const {
    return bias_;
  }  ///< of the gyro, rad/s; its vertical part is not observed

 private:
  AttitudeOptions options_;
  Eigen::Vector3d up_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
};

}  // namespace walking
