#include "walking/attitude.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "walking/plan.h"

namespace walking {

using Eigen::Vector3d;

Attitude::Attitude(const Eigen::Vector3d& up, const AttitudeOptions& options)
    : options_(options), up_(up.normalized()) {}

void Attitude::update(const Eigen::Vector3d& gyro, const Eigen::Vector3d& specific_force,
                      const Eigen::Vector3d& motion, double dt) {
  const Eigen::Vector3d measured_up = specific_force - motion;
  // The turn that would bring the tracked vertical to the measured one (Mahony et al. 2008, eq. (32)).
  // Readings of landings are used too: the impulses and the motion they end average to zero only together.
  const Vector3d correction = up_.cross(measured_up) / kGravity;
  bias_ += options_.bias_gain_per_s2 * dt * correction;
  const Eigen::Vector3d turn = (gyro - bias_ - options_.accelerometer_gain_per_s * correction) * dt;
  const double angle = turn.norm();
  if (angle > 0) {
    up_ = (Eigen::AngleAxisd(-angle, turn / angle) * up_).normalized();
  }
}

}  // namespace walking
