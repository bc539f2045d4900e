// The stabiliser: corrects the planned posture by the readings of IMU, ankle force sensors and encoders. It
// never sees a true pose.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string_view>

#include "walking/attitude.h"
#include "walking/plan.h"

namespace walking {

/// Force (N) and torque (N·m) that the ground exerts on a foot, in the axes of the sole, about the sole
/// point.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
};

/// The readings of the robot's own sensors at a tick.
struct SensorReadings {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();  ///< rad/s, chest IMU axes, mean over the last 5 ms
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  ///< m/s², specific force, chest IMU axes
  Wrench left, right;
  JointVector q = JointVector::Zero();  ///< encoders, rad
};

enum class TrackingLaw { capture_point, delayed_zmp };
inline constexpr std::array<std::string_view, 2> kTrackingLaws{"capture_point", "delayed_zmp"};

/// The scenario's keys stabilizer.*. Each block can be switched off.
struct StabilizerOptions {
  bool enabled = true;

  /// White noise of the 200 Hz readings that the stabiliser is given, whatever errors.* says of those that
  /// the filter is given: one recorded walk serves replays with any sensor errors.
  double gyro_sigma_rad_s = 0.01, accelerometer_sigma_m_s2 = 0.05;

  AttitudeOptions attitude;

  /// The error of the capture point asks for a ZMP that drives it back (Caron et al. 2019, section III), or
  /// the errors of the centre of mass, its velocity and the ZMP do (Kajita et al. 2010, eq. (26)).
  struct Tracking {
    bool enabled = true;
    TrackingLaw law = TrackingLaw::capture_point;
    double gain_per_s = 3.0;
    double velocity_cutoff_hz = 6.0;
    double sole_margin_m = 0.01;
    struct DelayedZmp {
      double lag_s = 0.04;
      double fast_pole_per_s = 13, slow_pole_per_s = 4;

      static void keys(auto&& key) {
        number<&DelayedZmp::lag_s>(
            key, 1e-3, 1e6,
            "time constant with which the ZMP follows the desired one in the delayed_zmp law");
        number<&DelayedZmp::fast_pole_per_s>(
            key, 0, 1e6, "faster of the two decay rates that the delayed_zmp law gives to errors");
        number<&DelayedZmp::slow_pole_per_s>(
            key, 0, 1e6, "slower of the two decay rates that the delayed_zmp law gives to errors");
      }
    } delayed_zmp;

    static void keys(auto&& key) {
      value<&Tracking::enabled>(key, "whether errors of the centre of mass are fed back");
      choice<&Tracking::law>(
          key, kTrackingLaws,
          "feedback law: of the capture point, or of the centre of mass, its velocity and a delayed ZMP");
      number<&Tracking::gain_per_s>(key, 0, 1e6, "rate at which the error of the capture point decays");
      number<&Tracking::velocity_cutoff_hz>(
          key, 0.01, 100,
          "cut-off frequency of the low-pass filter on the velocity error of the centre of mass");
      number<&Tracking::sole_margin_m>(key, 0, 0.1,
                                       "least distance of the desired ZMP from the edge of the soles");
      part<&Tracking::delayed_zmp>(key);
    }
  } tracking;

  /// While both feet stand they share the load as the desired ZMP divides the way between them (Kajita et al.
  /// 2010, section III-C); switched off, each is to carry half.
  struct Distribution {
    bool enabled = true;

    static void keys(auto&& key) {
      value<&Distribution::enabled>(
          key, "whether the feet share the load according to the desired ZMP; otherwise each carries half");
    }
  } distribution;

  /// Ankles yield to the measured torque beyond the desired one (Kajita et al. 2010, eqs. (14)-(17)).
  struct AnkleAdmittance {
    bool enabled = true;
    double gain_rad_s_per_nm = 0.08;
    double leak_s = 1.5;
    double limit_rad = 0.17;

    static void keys(auto&& key) {
      value<&AnkleAdmittance::enabled>(key, "whether the ankles yield to the measured torque (admittance)");
      number<&AnkleAdmittance::gain_rad_s_per_nm>(
          key, 0, 1e6, "angular velocity of an ankle for each N·m of torque beyond the desired one");
      number<&AnkleAdmittance::leak_s>(key, 1e-3, 1e6,
                                       "time constant with which the ankle correction decays");
      number<&AnkleAdmittance::limit_rad>(key, 0, 1, "largest ankle correction");
    }
  } ankle_admittance;

  /// The foot that carries too little is lowered, the other one raised (Kajita et al. 2010, eq. (18)).
  struct ForceDifference {
    bool enabled = true;
    double gain_m_s_per_n = 1e-5;
    double leak_s = 1.5;
    double leak_in_swing_s = 0.08;
    double limit_m = 0.025;

    static void keys(auto&& key) {
      value<&ForceDifference::enabled>(
          key, "whether the foot that carries too little is lowered and the other one raised");
      number<&ForceDifference::gain_m_s_per_n>(key, 0, 1e6,
                                               "velocity of a foot for each N of missing vertical force");
      number<&ForceDifference::leak_s>(
          key, 1e-3, 1e6, "time constant with which the foot height correction decays while both feet stand");
      number<&ForceDifference::leak_in_swing_s>(
          key, 1e-3, 1e6, "time constant with which the foot height correction decays while one foot swings");
      number<&ForceDifference::limit_m>(key, 0, 0.2, "largest foot height correction");
    }
  } force_difference;

  /// A leg is made longer by what its planned load compresses it, so that the other foot lands when it
  /// should. The stiffness is that of servos and ankle bush together.
  struct LegCompliance {
    bool enabled = true;
    double stiffness_n_m = 120e3;
    double lag_s = 0.03;

    static void keys(auto&& key) {
      value<&LegCompliance::enabled>(key,
                                     "whether a leg is lengthened by the compression under its planned load");
      number<&LegCompliance::stiffness_n_m>(key, 1e3, 1e9,
                                            "vertical stiffness of a leg from waist to ground");
      number<&LegCompliance::lag_s>(key, 0, 1, "time constant with which a leg is compressed");
    }
  } leg_compliance;

  /// The waist is turned against its estimated tilt (Kajita et al. 2010, eqs. (1)-(2)).
  struct BodyAttitude {
    bool enabled = true;
    double gain_per_s = 2.0;
    double leak_s = 10.0;
    double limit_rad = 0.1;

    static void keys(auto&& key) {
      value<&BodyAttitude::enabled>(key, "whether the waist is turned against its estimated tilt");
      number<&BodyAttitude::gain_per_s>(key, 0, 1e6, "rate at which the tilt of the waist is corrected");
      number<&BodyAttitude::leak_s>(key, 1e-3, 1e6, "time constant with which the waist correction decays");
      number<&BodyAttitude::limit_rad>(key, 0, 1, "largest waist correction");
    }
  } body_attitude;

  static void keys(auto&& key) {
    value<&StabilizerOptions::enabled>(key,
                                       "whether the plan is corrected by the robot's own sensor readings");
    number<&StabilizerOptions::gyro_sigma_rad_s>(
        key, 0, 1e3, "white noise of the 200 Hz gyro readings that the stabiliser is given");
    number<&StabilizerOptions::accelerometer_sigma_m_s2>(
        key, 0, 1e3, "white noise of the 200 Hz accelerometer readings that the stabiliser is given");
    part<&StabilizerOptions::attitude>(key);
    part<&StabilizerOptions::tracking>(key);
    part<&StabilizerOptions::distribution>(key);
    part<&StabilizerOptions::ankle_admittance>(key);
    part<&StabilizerOptions::force_difference>(key);
    part<&StabilizerOptions::leg_compliance>(key);
    part<&StabilizerOptions::body_attitude>(key);
  }
};

/// p = p_ref + position e_x + velocity e_v + zmp e_p, the errors measured minus planned.
struct DelayedZmpGains {
  double position = 0, velocity = 0, zmp = 0;
};

/// The gains that give a pendulum of frequency `omega` (1/s), whose ZMP follows the desired one with a lag,
/// the poles -fast, -slow and -omega (Kajita et al. 2010, eqs. (24)-(27)).
DelayedZmpGains delayed_zmp_gains(double omega, const StabilizerOptions::Tracking::DelayedZmp& options);

/// Frequency of the pendulum whose length is the height of the centre of mass in half-sitting, 1/s.
double pendulum_frequency();

/// Estimates and set points of the stabiliser, for logs and tests.
struct StabilizerState {
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();       ///< roll, pitch of the waist, rad
  Eigen::Vector2d com_error = Eigen::Vector2d::Zero();  ///< measured minus planned, m in P
  Eigen::Vector2d com_velocity_error = Eigen::Vector2d::Zero();
  Eigen::Vector2d zmp_desired = Eigen::Vector2d::Zero();  ///< m in P
  /// m in P; the desired one while neither foot is in contact.
  Eigen::Vector2d zmp_measured = Eigen::Vector2d::Zero();

  /// Error of the capture point c + v/omega, m in P.
  Eigen::Vector2d capture_point_error() const;
};

/// One step every kPeriod, from the first tick of the walk on.
class Stabilizer {
 public:
  explicit Stabilizer(const StabilizerOptions& options = {});

  /// The posture of this tick: the plan corrected by the readings.
  Posture step(const Reference& reference, const SensorReadings& readings);

  const StabilizerState& state() const { return state_; }

 private:
  /// Vertical forces that the feet are to carry, N.
  struct Loads {
    double left = 0, right = 0;
  };

  void estimate_tilt(const Reference& reference, const SensorReadings& readings);
  void estimate_com(const Reference& reference, const SensorReadings& readings);
  void estimate_zmp(const Reference& reference, const SensorReadings& readings);
  void track_com(const Reference& reference);
  Loads distribute_load(const Reference& reference) const;
  void ankle_admittance(const Reference& reference, const SensorReadings& readings, const Loads& loads);
  Eigen::Vector2d desired_ankle_torque(const Eigen::Isometry3d& X_PS, const Eigen::Vector2d& shift,
                                       double load) const;
  void control_force_difference(const Reference& reference, const SensorReadings& readings,
                                const Loads& loads);
  void compensate_leg_compliance(const Loads& loads);
  void control_trunk_attitude();
  Posture corrected(const Reference& reference) const;

  StabilizerOptions options_;
  Attitude attitude_;
  StabilizerState state_;
  bool started_ = false;
  Eigen::Vector2d left_error_ = Eigen::Vector2d::Zero(),
                  right_error_ = Eigen::Vector2d::Zero();  // of the CoM over each sole
  Eigen::Vector2d left_ankle_ = Eigen::Vector2d::Zero(),
                  right_ankle_ = Eigen::Vector2d::Zero();  // roll, pitch, rad
  Eigen::Vector2d compression_ = Eigen::Vector2d::Zero();  // of left and right leg, m
  double foot_difference_ = 0;                             // left foot lowered against the right one, m
  Eigen::Vector2d trunk_ = Eigen::Vector2d::Zero();        // roll, pitch of the waist, rad
};

}  // namespace walking
