#include "walking/stabilizer.h"

#include <algorithm>
#include <cmath>

namespace walking {

using Eigen::Vector2d, Eigen::Vector3d;

Attitude::Attitude(const Eigen::Vector3d& up, const AttitudeOptions& options)
    : options_(options), up_(up.normalized()) {}

void Attitude::update(const Eigen::Vector3d& gyro, const Eigen::Vector3d& specific_force,
                      const Eigen::Vector3d& motion, double dt) {
  const Eigen::Vector3d measured_up = specific_force - motion;
  // The turn that would bring the tracked vertical to the measured one (Mahony et al. 2008, eq. (32)).
  // Readings at landings count, too: their impulses and the motion that these stop average to zero only
  // together.
  const Vector3d correction = up_.cross(measured_up) / kGravity;
  bias_ += options_.bias_gain_per_s2 * dt * correction;
  const Eigen::Vector3d turn = (gyro - bias_ - options_.accelerometer_gain_per_s * correction) * dt;
  const double angle = turn.norm();
  if (angle > 0) up_ = (Eigen::AngleAxisd(-angle, turn / angle) * up_).normalized();
}

namespace {

constexpr double kContact = 0.054;  // fraction of the weight; a foot with less load is in the air

// Time constants with which corrections decay, s: slower than a step while the corrections act, but faster
// than the swing of a foot in the air, which has to land flat and at its planned height.
constexpr double kAnkleLeak = 1.5, kAnkleLeakInAir = 0.1, kForceLeak = 1.5, kForceLeakInSwing = 0.08,
                 kTrunkLeak = 10;
constexpr double kCompressionLag = 0.03;  // s, time constant with which a leg yields to a new load

Eigen::Matrix3d turned(const Vector2d& roll_pitch) {
  return (Eigen::AngleAxisd(roll_pitch.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll_pitch.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

Vector2d clamped(const Vector2d& value, double limit) { return value.cwiseMax(-limit).cwiseMin(limit); }

/// One tick of a leaky integrator.
template <typename T>
T integrated(const T& value, const T& rate, double leak_s) {
  return value + kPeriod * (rate - value / leak_s);
}

}  // namespace

Stabilizer::Stabilizer(const Robot& robot, const StabilizerOptions& options)
    : robot_(robot),
      options_(options),
      weight_(robot.mass * kGravity),
      omega_(std::sqrt(kGravity / robot.com_height())),
      attitude_(Vector3d::UnitZ(), options.attitude) {}

/// The measured fraction of the load on the left foot, 0 to 1; the planned fraction while neither foot
/// is in contact.
double Stabilizer::left_share(const Reference& reference, const SensorReadings& readings) const {
  const double left = std::max(0.0, readings.left.force.z()), right = std::max(0.0, readings.right.force.z());
  if (left + right > kContact * weight_) return left / (left + right);
  return reference.support == Support::left ? 1.0 : reference.support == Support::right ? 0.0 : 0.5;
}

/// The roll and pitch torque about a sole point that puts the center of pressure at `shift` (m in P), limited
/// to the sole.
Vector2d Stabilizer::desired_ankle_torque(Side side, const Eigen::Isometry3d& X_PS, const Vector2d& shift,
                                          double load) const {
  const Leg& leg = robot_.leg(side);
  const double margin = options_.sole_margin_m;
  const Vector2d least = leg.sole_min.array() + margin, most = leg.sole_max.array() - margin;
  const Vector2d in_sole = (X_PS.linear().transpose() * Vector3d(shift.x(), shift.y(), 0)).head<2>();
  const Vector2d pressure = in_sole.cwiseMax(least).cwiseMin(most);
  return {pressure.y() * load, -pressure.x() * load};
}

Posture Stabilizer::step(const Reference& reference, const SensorReadings& readings) {
  if (!options_.enabled) return reference;
  estimate_tilt(reference, readings);
  estimate_com(reference, readings);
  track_com(reference);
  const Loads loads = distribute_load(reference);
  ankle_admittance(reference, readings, loads);
  control_force_difference(reference, readings, loads);
  compensate_leg_compliance(loads);
  control_trunk_attitude();
  started_ = true;
  return corrected(reference);
}

void Stabilizer::estimate_tilt(const Reference& reference, const SensorReadings& readings) {
  if (!options_.attitude.enabled) return;
  const Eigen::Matrix3d R_BG = imu_in_base(robot_, readings.q).linear();
  const Eigen::Matrix3d R_PB = reference.X_PB.linear() * turned(state_.tilt);
  attitude_.update(readings.gyro, readings.accelerometer,
                   (R_PB * R_BG).transpose() * reference.com_acceleration, kPeriod);
  const Vector3d up = R_BG * attitude_.up();
  state_.tilt << std::atan2(up.y(), up.z()), std::atan2(-up.x(), std::hypot(up.y(), up.z()));
}

/// The error of the center of mass, by encoders and tilt over each planned sole, weighted with the measured
/// loads.
void Stabilizer::estimate_com(const Reference& reference, const SensorReadings& readings) {
  const Eigen::Matrix3d R_PB = reference.X_PB.linear() * turned(state_.tilt);
  const auto error_over = [&](Side side, const Eigen::Isometry3d& X_PS) -> Vector2d {
    const Leg& leg = robot_.leg(side);
    const Vector3d ankle = leg.ankle(),
                   p_BA = sole_in_base(robot_, side, leg_angles(leg, readings.q)) * ankle;
    const Vector3d com = X_PS * ankle + R_PB * (robot_.com - p_BA);
    // Shifting the plan's frame does not move the robot.
    return (com - reference.com).head<2>() + reference.frame_shift;
  };
  const Vector2d left = error_over(Side::left, reference.X_PL),
                 right = error_over(Side::right, reference.X_PR);
  const double share = left_share(reference, readings);
  if (started_) {
    // Differences are taken per foot, because a change of the supporting foot must not count as a velocity.
    const Vector2d rate = (share * (left - left_error_) + (1 - share) * (right - right_error_)) / kPeriod;
    const double keep = std::exp(-2 * std::numbers::pi * options_.tracking.velocity_cutoff_hz * kPeriod);
    state_.com_velocity_error = keep * state_.com_velocity_error + (1 - keep) * rate;
  }
  left_error_ = left;
  right_error_ = right;
  state_.com_error = share * left + (1 - share) * right - reference.frame_shift;
}

/// The capture point ξ = c + ċ/ω obeys ξ̇ = ω(ξ − z): z = z_ref + (1 + k/ω) Δξ makes Δξ decay at the rate k.
void Stabilizer::track_com(const Reference& reference) {
  const StabilizerOptions::Tracking& o = options_.tracking;
  state_.zmp_desired = reference.zmp;
  if (!o.enabled) return;
  const Vector2d capture_point_error = state_.com_error + state_.com_velocity_error / omega_;
  state_.zmp_desired += (1 + o.gain_per_s / omega_) * capture_point_error;
}

Stabilizer::Loads Stabilizer::distribute_load(const Reference& reference) const {
  const Vector2d left = reference.X_PL.translation().head<2>(),
                 right = reference.X_PR.translation().head<2>();
  double share = reference.support == Support::left ? 1.0 : 0.0;
  if (reference.support == Support::both)
    share = options_.distribution.enabled
                ? std::clamp((state_.zmp_desired - right).dot(left - right) / (left - right).squaredNorm(),
                             0.0, 1.0)
                : 0.5;
  return {share * weight_, (1 - share) * weight_};
}

void Stabilizer::ankle_admittance(const Reference& reference, const SensorReadings& readings,
                                  const Loads& loads) {
  const StabilizerOptions::AnkleAdmittance& o = options_.ankle_admittance;
  if (!o.enabled) return;
  const Vector2d left = reference.X_PL.translation().head<2>(),
                 right = reference.X_PR.translation().head<2>();
  // The part of the desired ZMP that the loads do not produce becomes an equal shift of pressure in both
  // soles.
  const Vector2d shift = state_.zmp_desired - (loads.left * left + loads.right * right) / weight_;
  const auto update = [&](Side side, Vector2d& ankle, const Eigen::Isometry3d& X_PS, const Wrench& wrench,
                          double load) {
    const bool in_the_air = load == 0 && wrench.force.z() < kContact * weight_;
    // A foot that rolls to the left presses on its right edge, which means less torque about x.
    const Vector2d rate =
        o.gain_rad_s_per_nm * (wrench.torque.head<2>() - desired_ankle_torque(side, X_PS, shift, load));
    ankle = clamped(integrated<Vector2d>(ankle, in_the_air ? Vector2d::Zero() : rate,
                                         in_the_air ? kAnkleLeakInAir : kAnkleLeak),
                    o.largest_rad);
  };
  update(Side::left, left_ankle_, reference.X_PL, readings.left, loads.left);
  update(Side::right, right_ankle_, reference.X_PR, readings.right, loads.right);
}

void Stabilizer::control_force_difference(const Reference& reference, const SensorReadings& readings,
                                          const Loads& loads) {
  const StabilizerOptions::ForceDifference& o = options_.force_difference;
  if (!o.enabled) return;
  const bool both = reference.support == Support::both;
  const double missing = (loads.left - loads.right) - (readings.left.force.z() - readings.right.force.z());
  foot_difference_ = integrated(foot_difference_, both ? o.gain_m_s_per_n * missing : 0.0,
                                both ? kForceLeak : kForceLeakInSwing);
  foot_difference_ = std::clamp(foot_difference_, -kLargestFootDifference_m, kLargestFootDifference_m);
}

void Stabilizer::compensate_leg_compliance(const Loads& loads) {
  const StabilizerOptions::LegCompliance& o = options_.leg_compliance;
  if (!o.enabled) return;
  const Vector2d loaded = Vector2d(loads.left, loads.right) / o.stiffness_n_m;
  compression_ += (1 - std::exp(-kPeriod / kCompressionLag)) * (loaded - compression_);
}

void Stabilizer::control_trunk_attitude() {
  const StabilizerOptions::BodyAttitude& o = options_.body_attitude;
  if (!o.enabled) return;
  trunk_ = clamped(integrated<Vector2d>(trunk_, -o.gain_per_s * state_.tilt, kTrunkLeak), kLargestTrunk_rad);
}

Posture Stabilizer::corrected(const Reference& reference) const {
  Posture posture = reference;
  posture.X_PB.linear() = reference.X_PB.linear() * turned(trunk_);
  // The turn must not move the center of mass.
  posture.X_PB.translation() += (reference.X_PB.linear() - posture.X_PB.linear()) * robot_.com;
  posture.X_PL.linear() = reference.X_PL.linear() * turned(left_ankle_);
  posture.X_PR.linear() = reference.X_PR.linear() * turned(right_ankle_);
  posture.X_PL.translation().z() -= foot_difference_ / 2 + compression_[0];
  posture.X_PR.translation().z() -= -foot_difference_ / 2 + compression_[1];
  return posture;
}

}  // namespace walking
