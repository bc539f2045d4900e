// Keeps the robot on its feet from what its own sensors say: attitude, ankle forces, encoders. No true pose
// comes here.
#pragma once

#include <Eigen/Geometry>

#include "walking/attitude.h"
#include "walking/plan.h"

namespace walking {

/// Force (N) and torque (N·m) that the ground exerts on a foot, in the axes of the sole, about the sole
/// point.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
};

/// What the robot's own sensors say at a tick.
struct Felt {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();  ///< rad/s, chest IMU axes, mean over the last 5 ms
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  ///< m/s², specific force, chest IMU axes
  Wrench left, right;
  JointVector q = JointVector::Zero();  ///< encoders, rad
};

/// Where the stabiliser wants waist and soles, in P, and the plan's arms, for the inverse kinematics.
struct Posture {
  Eigen::Isometry3d X_PB = Eigen::Isometry3d::Identity(), X_PL = Eigen::Isometry3d::Identity(),
                    X_PR = Eigen::Isometry3d::Identity();
  Arms arms;
};

/// The plan's own posture, uncorrected.
inline Posture posture_of(const Reference& reference) {
  return {reference.X_PB, reference.X_PL, reference.X_PR, reference.arms};
}

enum class TrackingLaw { capture_point, delayed_zmp };

/// The scenario's keys stabilizer.*, name for name. Each block can be switched off.
struct StabilizerOptions {
  bool enabled = true;
  AttitudeOptions attitude;

  /// The error of the capture point asks for a ZMP that drives it back (Caron et al. 2019, section III), or
  /// the errors of the centre of mass, its velocity and the ZMP do (Kajita et al. 2010, eq. (26)).
  struct Tracking {
    bool enabled = true;
    TrackingLaw law = TrackingLaw::capture_point;
    double gain_per_s = 3.0;  ///< how fast the error of the capture point shall decay
    struct DelayedZmp {
      double lag_s = 0.04;  ///< with which the ZMP follows the one asked for
      double fast_pole_per_s = 13, slow_pole_per_s = 4;
    } delayed_zmp;
    double velocity_cutoff_hz = 6.0;  ///< low pass on the velocity error of the centre of mass
    double sole_margin_m = 0.01;      ///< the pressure asked for stays this far inside a sole
  } tracking;

  /// While both feet stand they share the load as the ZMP asked for divides the way between them (Kajita et
  /// al. 2010, section III-C); switched off, each is to carry half.
  struct Distribution {
    bool enabled = true;
  } distribution;

  /// Ankles give way to the torque they feel beyond what is asked for (Kajita et al. 2010, eqs. (14)-(17)).
  struct AnkleAdmittance {
    bool enabled = true;
    double gain_rad_s_per_nm = 0.08;
    double leak_s = 1.5;
    double limit_rad = 0.17;
  } ankle_admittance;

  /// The foot that carries too little reaches down, the other up (Kajita et al. 2010, eq. (18)).
  struct ForceDifference {
    bool enabled = true;
    double gain_m_s_per_n = 1e-5;
    double leak_s = 1.5;  ///< while both feet are planned to stand
    double leak_in_swing_s = 0.08;
    double limit_m = 0.025;
  } force_difference;

  /// A leg is made longer by what its planned load compresses it, so that the other foot lands when it
  /// should.
  struct LegCompliance {
    bool enabled = true;
    double stiffness_n_m = 120e3;  ///< of a leg from waist to ground, vertically: servos and ankle bush
    double lag_s = 0.03;
  } leg_compliance;

  /// The waist is turned against its felt tilt (Kajita et al. 2010, eqs. (1)-(2)).
  struct BodyAttitude {
    bool enabled = true;
    double gain_per_s = 2.0;
    double leak_s = 10.0;
    double limit_rad = 0.1;
  } body_attitude;
};

/// p = p_ref + position e_x + velocity e_v + zmp e_p, the errors felt minus planned.
struct DelayedZmpGains {
  double position = 0, velocity = 0, zmp = 0;
};

/// The gains that give a pendulum of frequency `omega` (1/s), whose ZMP follows the one asked for with a lag,
/// the poles -fast, -slow and -omega (Kajita et al. 2010, eqs. (24)-(27)).
DelayedZmpGains delayed_zmp_gains(double omega, const StabilizerOptions::Tracking::DelayedZmp& options);

/// What the stabiliser believes and asks for: for logs and tests.
struct StabilizerState {
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();       ///< roll, pitch of the waist, rad
  Eigen::Vector2d com_error = Eigen::Vector2d::Zero();  ///< felt minus planned, m in P
  Eigen::Vector2d com_velocity_error = Eigen::Vector2d::Zero();
  Eigen::Vector2d zmp_asked = Eigen::Vector2d::Zero();  ///< m in P
  Eigen::Vector2d zmp_felt =
      Eigen::Vector2d::Zero();  ///< m in P; the one asked for while neither foot feels the ground
};

/// One step every kPeriod, from the first tick of the walk on.
class Stabilizer {
 public:
  explicit Stabilizer(const StabilizerOptions& options = {});

  /// The plan of this tick, corrected by what was felt at it.
  Posture step(const Reference& reference, const Felt& felt);

  const StabilizerState& state() const { return state_; }

 private:
  struct Load {
    double left = 0, right = 0;  // N, vertical
  };

  void estimate_tilt(const Reference& reference, const Felt& felt);
  void estimate_com(const Reference& reference, const Felt& felt);
  void estimate_zmp(const Reference& reference, const Felt& felt);
  void ask_for_zmp(const Reference& reference);
  Load share(const Reference& reference) const;
  void give_way_at_ankles(const Reference& reference, const Felt& felt, const Load& load);
  void balance_forces(const Reference& reference, const Felt& felt, const Load& load);
  void carry(const Load& load);
  void right_the_body();
  Posture corrected(const Reference& reference) const;

  StabilizerOptions options_;
  Attitude attitude_;
  StabilizerState state_;
  bool begun_ = false;
  Eigen::Vector2d left_error_ = Eigen::Vector2d::Zero(),
                  right_error_ = Eigen::Vector2d::Zero();  // of the CoM over each sole
  Eigen::Vector2d left_ankle_ = Eigen::Vector2d::Zero(),
                  right_ankle_ = Eigen::Vector2d::Zero();  // roll, pitch, rad
  Eigen::Vector2d compression_ = Eigen::Vector2d::Zero();  // of left and right leg, m
  double reach_ = 0;                                       // of the left foot down and the right one up, m
  Eigen::Vector2d body_ = Eigen::Vector2d::Zero();         // roll, pitch of the waist, rad
};

}  // namespace walking
