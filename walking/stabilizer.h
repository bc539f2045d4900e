// Corrects the planned posture using readings of IMU, ankle force sensors and encoders, never the true pose.
#pragma once

#include "walking/plan.h"

namespace walking {

/// Options of the attitude filter.
struct AttitudeOptions {
  bool enabled = true;
  double accelerometer_gain_per_s = 0.15;
  double bias_gain_per_s2 = 0.004;

  static void keys(auto&& key) {
    value<&AttitudeOptions::enabled>(
        key,
        "whether the tilt of the waist is estimated from gyro and accelerometer; otherwise the waist "
        "is assumed to be upright");
    number<&AttitudeOptions::accelerometer_gain_per_s>(
        key, 0, 1e6, "rate at which the estimated vertical is corrected toward the accelerometer's");
    number<&AttitudeOptions::bias_gain_per_s2>(key, 0, 1e6,
                                               "gain of the attitude filter's estimate of the gyro bias");
  }
};

/// Tracks the vertical in the axes of the IMU. The heading is not observable.
class Attitude {
 public:
  /// up: the initial vertical in the IMU's axes, of any length.
  explicit Attitude(const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ(),
                    const AttitudeOptions& options = {});

  /// Adds an interval of dt (s) with its mean angular velocity (rad/s) and specific force (m/s²), both in IMU
  /// axes. motion: the planned acceleration of the robot (m/s²), in the same axes. It is subtracted from the
  /// specific force, so that gravity remains.
  void update(const Eigen::Vector3d& gyro, const Eigen::Vector3d& specific_force,
              const Eigen::Vector3d& motion, double dt);

  const Eigen::Vector3d& up() const { return up_; }  ///< unit vector, IMU axes
  /// The bias of the gyro, rad/s. Its vertical component is not observable.
  const Eigen::Vector3d& bias() const { return bias_; }

 private:
  AttitudeOptions options_;
  Eigen::Vector3d up_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
};

/// The force (N) and torque (N·m about the sole point) that the ground exerts on a foot, in the axes of the
/// sole.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
};

/// The readings of the robot's own sensors at a tick.
struct SensorReadings {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();           ///< rad/s, chest axes, mean over the last 5 ms
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  ///< m/s², specific force, chest axes
  Wrench left, right;
  JointVector q;  ///< encoders, rad
};

/// The scenario's keys under stabilizer. Each block can be switched off.
struct StabilizerOptions {
  bool enabled = true;

  /// White noise of the stabilizer's 200 Hz readings. It is separate from errors.*, so that one walk serves
  /// all sensor errors.
  double gyro_sigma_rad_s = 0.01, accelerometer_sigma_m_s2 = 0.05;

  AttitudeOptions attitude;

  /// The ZMP drives the error of the capture point back to zero (Caron et al. 2019, section III).
  struct Tracking {
    bool enabled = true;
    double gain_per_s = 3.0;
    /// Time constant of the low-pass filter on the velocity error of the center of mass.
    static constexpr double velocity_cutoff_hz = 6.0;

    static void keys(auto&& key) {
      value<&Tracking::enabled>(key, "whether errors of the center of mass are fed back");
      number<&Tracking::gain_per_s>(key, 0, 1e6, "decay rate of the capture point error");
    }
  } tracking;

  /// While both feet stand, they share the load in the ratio in which the desired ZMP divides the line
  /// between them (Kajita et al. 2010, section III-C). If switched off, each carries half.
  struct Distribution {
    bool enabled = true;

    static void keys(auto&& key) {
      value<&Distribution::enabled>(
          key, "whether the feet share the load according to the desired ZMP; otherwise each carries half");
    }
  } distribution;

  /// The ankles yield to measured torque in excess of the desired one (Kajita et al. 2010, eqs. (14)-(17)).
  struct AnkleAdmittance {
    bool enabled = true;
    double gain_rad_s_per_nm = 0.08;
    double largest_rad = 0.17;  // limit in case of faulty sensors

    static void keys(auto&& key) {
      value<&AnkleAdmittance::enabled>(key, "whether the ankles yield to the measured torque (admittance)");
      number<&AnkleAdmittance::gain_rad_s_per_nm>(
          key, 0, 1e6, "angular velocity of an ankle per N·m of torque in excess of the desired one");
      degrees<&AnkleAdmittance::largest_rad>(key, 0, 45, "largest correction of an ankle");
    }
  } ankle_admittance;

  /// The foot that carries too little is lowered, and the other one is raised (Kajita et al. 2010, eq. (18)).
  struct ForceDifference {
    bool enabled = true;
    double gain_m_s_per_n = 1e-5;

    static void keys(auto&& key) {
      value<&ForceDifference::enabled>(
          key, "whether the foot that carries too little is lowered and the other one raised");
      number<&ForceDifference::gain_m_s_per_n>(key, 0, 1e6,
                                               "velocity of a foot per N of missing vertical force");
    }
  } force_difference;

  /// A leg is lengthened by the compression under its planned load, so that the other foot lands on time.
  /// The stiffness includes servos and ankle bushing.
  struct LegCompliance {
    bool enabled = true;
    double stiffness_n_m = 120e3;

    static void keys(auto&& key) {
      value<&LegCompliance::enabled>(key,
                                     "whether a leg is lengthened by the compression under its planned load");
      number<&LegCompliance::stiffness_n_m>(key, 1e3, 1e9,
                                            "vertical stiffness of a leg from waist to ground");
    }
  } leg_compliance;

  /// The waist is turned against its estimated tilt (Kajita et al. 2010, eqs. (1)-(2)).
  struct BodyAttitude {
    bool enabled = true;
    double gain_per_s = 2.0;

    static void keys(auto&& key) {
      value<&BodyAttitude::enabled>(key, "whether the waist is turned against its estimated tilt");
      number<&BodyAttitude::gain_per_s>(key, 0, 1e6, "correction rate of the tilt of the waist");
    }
  } body_attitude;

  /// Footholds move by the error of the capture point, and the plan's frame follows.
  struct LandingAdjustment {
    bool enabled = false;
    double growth_fraction = 0.6;
    static constexpr double dead_zone_m = 0.02;  ///< error at touch-down that is left without a correction
    double largest_m = 0.12;
    static constexpr double largest_inwards_m = 0.03;  ///< toward the stance foot
    static constexpr double shift_s = 0.08;  ///< duration of the shift of the plan's frame after touch-down

    static void keys(auto&& key) {
      value<&LandingAdjustment::enabled>(key,
                                         "whether footholds are moved by the error of the capture point");
      number<&LandingAdjustment::growth_fraction>(
          key, 0, 2, "growth rate of the capture point error until touch-down, relative to no control");
      number<&LandingAdjustment::largest_m>(key, 0, 1,
                                            "largest shift of a foothold along and across the foot");
    }
  } landing_adjustment;

  /// Minimum distance of the desired center of pressure from the edge of a sole.
  double sole_margin_m = 0.01;

  static void keys(auto&& key) {
    value<&StabilizerOptions::enabled>(key,
                                       "whether the plan is corrected by the robot's own sensor readings");
    number<&StabilizerOptions::gyro_sigma_rad_s>(key, 0, 1e3,
                                                 "white noise of the stabilizer's 200 Hz gyro readings");
    number<&StabilizerOptions::accelerometer_sigma_m_s2>(
        key, 0, 1e3, "white noise of the stabilizer's 200 Hz accelerometer readings");
    number<&StabilizerOptions::sole_margin_m>(
        key, 0, 0.1, "minimum distance of the desired center of pressure from the edge of a sole");
    part<&StabilizerOptions::attitude>(key);
    part<&StabilizerOptions::tracking>(key);
    part<&StabilizerOptions::distribution>(key);
    part<&StabilizerOptions::ankle_admittance>(key);
    part<&StabilizerOptions::force_difference>(key);
    part<&StabilizerOptions::leg_compliance>(key);
    part<&StabilizerOptions::body_attitude>(key);
    part<&StabilizerOptions::landing_adjustment>(key);
  }
};

/// Limits in case of faulty sensors: of the difference in height between the feet, and of the correction of
/// the waist.
inline constexpr double kLargestFootDifference_m = 0.025, kLargestTrunk_rad = 0.1;

/// Estimates and set points of the stabilizer, for logs and tests.
struct StabilizerState {
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();       ///< roll, pitch of the waist, rad
  Eigen::Vector2d com_error = Eigen::Vector2d::Zero();  ///< measured minus planned, m in P
  Eigen::Vector2d com_velocity_error = Eigen::Vector2d::Zero();
  Eigen::Vector2d zmp_desired = Eigen::Vector2d::Zero();  ///< m in P
};

/// Call step() once every kPeriod, starting with the first tick of the walk.
class Stabilizer {
 public:
  explicit Stabilizer(const Robot& robot, const StabilizerOptions& options = {});

  /// Returns the posture of this tick: the plan, corrected using the readings.
  Posture step(const Reference& reference, const SensorReadings& readings);

  const StabilizerState& state() const { return state_; }

 private:
  /// Vertical forces that the feet should carry, N.
  struct Loads {
    double left = 0, right = 0;
  };

  void estimate_tilt(const Reference& reference, const SensorReadings& readings);
  void estimate_com(const Reference& reference, const SensorReadings& readings);
  void track_com(const Reference& reference);
  Loads distribute_load(const Reference& reference) const;
  void ankle_admittance(const Reference& reference, const SensorReadings& readings, const Loads& loads);
  void control_force_difference(const Reference& reference, const SensorReadings& readings,
                                const Loads& loads);
  void compensate_leg_compliance(const Loads& loads);
  void control_trunk_attitude();
  Posture corrected(const Reference& reference) const;

  Eigen::Vector2d desired_ankle_torque(Side side, const Eigen::Isometry3d& X_PS, const Eigen::Vector2d& shift,
                                       double load) const;
  double left_share(const Reference& reference, const SensorReadings& readings) const;

  Robot robot_;
  StabilizerOptions options_;
  double weight_, omega_;  // N; 1/s, for a pendulum as high as the center of mass
  Attitude attitude_;
  StabilizerState state_;
  bool started_ = false;
  Eigen::Vector2d left_error_ = Eigen::Vector2d::Zero(),
                  right_error_ = Eigen::Vector2d::Zero();  // error of the center of mass over each sole
  Eigen::Vector2d left_ankle_ = Eigen::Vector2d::Zero(),
                  right_ankle_ = Eigen::Vector2d::Zero();  // roll, pitch, rad
  Eigen::Vector2d compression_ = Eigen::Vector2d::Zero();  // compression of left and right leg, m
  double foot_difference_ = 0;                             // height of the right foot above the left one, m
  Eigen::Vector2d trunk_ = Eigen::Vector2d::Zero();        // roll, pitch of the waist, rad
};

}  // namespace walking
