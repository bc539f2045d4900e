#include "sim/physics/imu.h"

namespace sim::physics {

ImuReading reading_between(const ImuState& from, const ImuState& to, const Eigen::Vector3d& gravity) {
  ImuReading reading{.begin = from.t, .end = to.t};
  const double dt = std::chrono::duration<double>(to.t - from.t).count();
  if (dt <= 0) {
    return reading;
  }
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(from.R_WG.transpose() * to.R_WG).normalized());
  reading.gyro = turn.axis() * (turn.angle() / dt);
  const Eigen::Matrix3d R_WG =
      from.R_WG * Eigen::AngleAxisd(turn.angle() / 2, turn.axis());  // in the middle of the interval
  reading.specific_force = R_WG.transpose() * ((to.v_WG - from.v_WG) / dt - gravity);
  return reading;
}

}  // namespace sim::physics
