// Leg odometry: how the legs moved the waist, from encoders and ankle forces.
#pragma once

#include "walking/stabilizer.h"

namespace walking {

/// Returns the sole in the waist's axes from a leg's six encoders (rad) and the deflection of the ankle's
/// bush, if it has one, under the wrench that the ground exerts on the foot.
Eigen::Isometry3d measured_sole_in_base(const Robot& robot, Side side, const LegVector& q,
                                        const Wrench& wrench);

/// X_SF: the floor in the axes of a sole that tilts on its pads, springs with damping, about its middle,
/// under a wrench that lags behind that of the ground by leg.pad_lag_s. By first order this is how they give
/// way.
Eigen::Isometry3d floor_under_sole(const Leg& leg, const Wrench& lagged);

/// The part assumed to be at rest: the whole flat sole that carries more, as on a planned walk, or the center
/// of pressure of each sole, as on slopes and on walks that roll over their feet. If the soles of a robot do
/// not lie flat (Leg::lies_flat), `sole` means the centers of pressure, on a floor at z = 0.
enum class AtRest { sole, points };

/// Follows the waist from one carrying sole to the next in the odometry's own world O with its floor at z =
/// 0; O drifts from the true world as soles slip, because the sole that carries more is assumed to be at
/// rest.
///
/// When the load changes, the new sole is placed relative to the other one, so the waist never jumps and
/// settles on the floor within tenths of a second. Tilt of a sole on an uneven floor is not observed: that
/// needs a gyro.
class LegOdometry {
 public:
  /// X_OB: the waist at the first readings.
  LegOdometry(const Robot& robot, const Eigen::Isometry3d& X_OB, AtRest at_rest = AtRest::sole)
      : robot_(robot),
        X_OB_start_(X_OB),
        by_points_(at_rest == AtRest::points || !robot.leg(Side::left).lies_flat ||
                   !robot.leg(Side::right).lies_flat),
        on_floor_(at_rest == AtRest::sole) {}

  /// Adds the readings of a tick, of each one: the sole with the greater load carries from here on.
  void add(const SensorReadings& readings);

  /// The waist, and the sole that carries the robot.
  struct Motion {
    Eigen::Isometry3d X_OB = Eigen::Isometry3d::Identity();
    Eigen::Vector3d p_OS = Eigen::Vector3d::Zero();
  };
  /// By the encoders at dt_s after the last add(), with its wrenches and, for points, its gyro.
  Motion motion(const JointVector& q, double dt_s = 0) const;

 private:
  Eigen::Isometry3d X_BS(Side side, const JointVector& q) const;
  void follow_points(const SensorReadings& readings);
  Motion turned(const JointVector& q, const Eigen::Vector3d& gyro, double dt_s) const;

  Robot robot_;
  Eigen::Isometry3d X_OB_start_, X_OS_ = Eigen::Isometry3d::Identity();  // X_OS_: of the sole that carries
  bool by_points_, on_floor_;                               // on_floor_: points come down to z = 0
  Eigen::Isometry3d X_OB_ = Eigen::Isometry3d::Identity();  // of the last readings, for points
  SensorReadings last_;                                     // likewise
  bool started_ = false;
  Side carrying_ = Side::left;
  struct Wrenches {
    Wrench now, lagged;  // lagged: as the pads follow them
  };
  std::array<Wrenches, 2> wrenches_;  // by Side
};

}  // namespace walking
