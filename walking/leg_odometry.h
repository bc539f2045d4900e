// Leg odometry: computes the motion of the waist from encoders and ankle forces.
#pragma once

#include "walking/stabilizer.h"
#include "walking/timeline.h"

namespace walking {

/// Returns the deflection (m or rad) of each spring of the ankle's bushing under a constant wrench from
/// the ground on the foot.
std::vector<double> deflections(const Leg& leg, const Wrench& wrench);

/// Returns the pose of the sole in the waist's axes from a leg's six encoders (rad) and the deflections of
/// its bushing.
Eigen::Isometry3d measured_sole_in_base(const Robot& robot, Side side, const LegVector& q,
                                        const std::vector<double>& bush);

/// X_SF: the floor in the axes of a sole that tilts about its middle on its pads, which act as springs with
/// damping. lagged: the wrench from the ground, low-pass filtered with leg.pad_lag_s, a first-order model of
/// how the pads yield.
Eigen::Isometry3d floor_under_sole(const Leg& leg, const Wrench& lagged);

/// level: the floor is the plane z = 0, as on a planned walk without slopes. any: its height and slope are
/// unknown.
enum class Floor { level, any };

/// Tracks the waist in the odometry's own world O, which drifts from the true world as soles slip.
///
/// On a level floor, and if the stiffness of the pads is known, the whole sole that carries more load is
/// assumed to be at rest. When the load shifts, the new sole is placed relative to the other one, so the
/// waist never jumps and settles on the floor within tenths of a second. Otherwise the gyro measures the
/// rotation of the waist, and the centers of pressure are assumed to be at rest unless this contradicts the
/// accelerometer.
class LegOdometry {
 public:
  /// X_OB: the pose of the waist at the first readings.
  LegOdometry(const Robot& robot, const Eigen::Isometry3d& X_OB, Floor floor = Floor::level)
      : robot_(robot),
        X_OB_start_(X_OB),
        floor_(floor),
        by_points_(floor == Floor::any || !robot.leg(Side::left).has_pads() ||
                   !robot.leg(Side::right).has_pads()) {}

  /// Sets the pose of the waist at the first readings, before them.
  void start_at(const Eigen::Isometry3d& X_OB) { X_OB_start_ = X_OB; }

  /// Adds the readings of a tick; to be called at every tick. From then on, the sole with the greater
  /// load carries the robot.
  void add(const SensorReadings& readings);

  /// Moves O on its floor so that the waist is at this place with this heading.
  void move_to(const FootPose& waist, const JointVector& q);

  /// The pose of the waist, and the position of the sole that carries the robot.
  struct Motion {
    Eigen::Isometry3d X_OB = Eigen::Isometry3d::Identity();
    Eigen::Vector3d p_OS = Eigen::Vector3d::Zero();
  };
  /// Returns the motion according to the encoders dt_s after the last add(), whose wrenches and, for
  /// points, gyro it uses.
  Motion motion(const JointVector& q, double dt_s = 0) const;

 private:
  Eigen::Isometry3d X_BS(Side side, const JointVector& q) const;
  void follow_points(const SensorReadings& readings);
  /// Returns the motion since the last readings, and the part of the load on feet at rest.
  std::pair<Motion, double> turned(const JointVector& q, const SensorReadings& inertial, double dt_s) const;

  Robot robot_;
  Eigen::Isometry3d X_OB_start_, X_OS_ = Eigen::Isometry3d::Identity();  // X_OS_: the sole that carries
  Floor floor_;
  bool by_points_;                                          // assumes centers of pressure at rest
  Eigen::Isometry3d X_OB_ = Eigen::Isometry3d::Identity();  // at the last readings, for points
  SensorReadings last_;                                     // likewise
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();      // likewise, of the IMU, horizontal, m/s in O
  double coasted_s_ = 0;                                    // since the load was on feet at rest
  bool started_ = false;
  Side carrying_ = Side::left;
  struct Foot {
    std::vector<double> bush;                                // deflections
    Wrench pads;                                             // the wrench that the pads have followed
    Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();  // at the last readings, for points
  };
  std::array<Foot, 2> feet_;  // by Side
};

}  // namespace walking
