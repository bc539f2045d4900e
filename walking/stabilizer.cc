#include "walking/stabilizer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "walking/forward_kinematics.h"
#include "walking/hrp2.h"

namespace walking {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double kWeight = 56.867992 * kGravity;  // N
const double kOmega =
    std::sqrt(kGravity / 0.808291);    // 1/s, of the pendulum with the half-sitting CoM height
constexpr double kGroundForce = 30.0;  // N, a foot that feels less is in the air
constexpr double kAirLeak = 0.1;       // s, in which an ankle in the air comes back

const Vector3d kAnkle(0, 0, hrp2::kAnkleHeight);  // in the axes of the sole

// The sole about the sole point, m.
const Vector2d kSoleMin(-0.100, -0.069), kSoleMax(0.130, 0.069);

Eigen::Matrix3d turned(const Vector2d& roll_pitch) {
  return (Eigen::AngleAxisd(roll_pitch.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll_pitch.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Matrix3d chest_in_waist(const JointVector& q) {
  return (Eigen::AngleAxisd(q[12], Vector3d::UnitZ()) * Eigen::AngleAxisd(q[13], Vector3d::UnitY()))
      .toRotationMatrix();
}

Vector2d clamped(const Vector2d& value, double limit) { return value.cwiseMax(-limit).cwiseMin(limit); }

/// One tick of a leaky integrator.
template <typename T>
T integrated(const T& value, const T& rate, double leak_s) {
  return value + kPeriod * (rate - value / leak_s);
}

/// How much of the weight the left foot feels, 0 ... 1; the plan's word while neither feels the ground.
double left_share(const Reference& reference, const Felt& felt) {
  const double left = std::max(0.0, felt.left.force.z()), right = std::max(0.0, felt.right.force.z());
  if (left + right > kGroundForce) {
    return left / (left + right);
  }
  return reference.support == Support::left ? 1.0 : reference.support == Support::right ? 0.0 : 0.5;
}

/// Centre of pressure of a foot in P, weighted with its vertical force.
Vector2d weighted_pressure(const Eigen::Isometry3d& X_PS, const Wrench& wrench) {
  const Vector3d moment(-wrench.torque.y(), wrench.torque.x(), 0);
  return (X_PS.translation() * wrench.force.z() + X_PS.linear() * moment).head<2>();
}

}  // namespace

/// Of (s + fast)(s + slow)(s + omega) = det(sI - A), A the pendulum with its lagging ZMP under feedback.
DelayedZmpGains delayed_zmp_gains(double omega, const StabilizerOptions::Tracking::DelayedZmp& options) {
  const double a = options.fast_pole_per_s, b = options.slow_pole_per_s, T = options.lag_s;
  const double sum = a + b + omega, pairs = a * b + (a + b) * omega, all = a * b * omega;
  const double square = omega * omega;
  return {T * (all + square * sum) / square, T * (pairs + square) / square, 1 - T * sum};
}

Stabilizer::Stabilizer(const StabilizerOptions& options)
    : options_(options), attitude_(Vector3d::UnitZ(), options.attitude) {}

Posture Stabilizer::step(const Reference& reference, const Felt& felt) {
  if (!options_.enabled) {
    return posture_of(reference);
  }
  estimate_tilt(reference, felt);
  estimate_com(reference, felt);
  estimate_zmp(reference, felt);
  ask_for_zmp(reference);
  const Load load = share(reference);
  give_way_at_ankles(reference, felt, load);
  balance_forces(reference, felt, load);
  carry(load);
  right_the_body();
  begun_ = true;
  return corrected(reference);
}

void Stabilizer::estimate_tilt(const Reference& reference, const Felt& felt) {
  if (!options_.attitude.enabled) return;
  const Eigen::Matrix3d R_BG = chest_in_waist(felt.q);
  const Eigen::Matrix3d R_PB = reference.X_PB.linear() * turned(state_.tilt);
  attitude_.update(felt.gyro, felt.accelerometer, (R_PB * R_BG).transpose() * reference.com_acceleration,
                   kPeriod);
  const Vector3d up = R_BG * attitude_.up();
  state_.tilt << std::atan2(up.y(), up.z()), std::atan2(-up.x(), std::hypot(up.y(), up.z()));
}

/// The centre of mass as the encoders and the felt tilt put it over each planned sole, weighted with the felt
/// forces.
void Stabilizer::estimate_com(const Reference& reference, const Felt& felt) {
  const Eigen::Matrix3d R_PB = reference.X_PB.linear() * turned(state_.tilt);
  const auto error_over = [&](const Eigen::Isometry3d& X_PS, const Eigen::Isometry3d& X_BS) -> Vector2d {
    const Vector3d com = X_PS * kAnkle + R_PB * (hrp2::kComInWaist - X_BS * kAnkle);
    return (com - reference.com).head<2>();
  };
  const Vector2d left = error_over(reference.X_PL, sole_in_waist(Side::left, felt.q.segment<6>(6)));
  const Vector2d right = error_over(reference.X_PR, sole_in_waist(Side::right, felt.q.segment<6>(0)));
  const double share = left_share(reference, felt);
  if (begun_) {
    // Each foot's own difference: a step from one foot to the other is no velocity.
    const Vector2d rate = (share * (left - left_error_) + (1 - share) * (right - right_error_)) / kPeriod;
    const double keep = std::exp(-2 * std::numbers::pi * options_.tracking.velocity_cutoff_hz * kPeriod);
    state_.com_velocity_error = keep * state_.com_velocity_error + (1 - keep) * rate;
  }
  left_error_ = left;
  right_error_ = right;
  state_.com_error = share * left + (1 - share) * right;
}

void Stabilizer::estimate_zmp(const Reference& reference, const Felt& felt) {
  const double force = felt.left.force.z() + felt.right.force.z();
  if (force < kGroundForce) {
    state_.zmp_felt = state_.zmp_asked;
    return;
  }
  state_.zmp_felt =
      (weighted_pressure(reference.X_PL, felt.left) + weighted_pressure(reference.X_PR, felt.right)) / force;
}

/// Capture point ξ = c + ċ/ω obeys ξ̇ = ω(ξ − z): z = z_ref + (1 + k/ω) Δξ makes Δξ decay at the rate k.
void Stabilizer::ask_for_zmp(const Reference& reference) {
  const StabilizerOptions::Tracking& o = options_.tracking;
  state_.zmp_asked = reference.zmp;
  if (!o.enabled) return;
  if (o.law == TrackingLaw::capture_point) {
    state_.zmp_asked += (1 + o.gain_per_s / kOmega) * (state_.com_error + state_.com_velocity_error / kOmega);
    return;
  }
  const DelayedZmpGains c = delayed_zmp_gains(kOmega, o.delayed_zmp);
  state_.zmp_asked += c.position * state_.com_error + c.velocity * state_.com_velocity_error +
                      c.zmp * (state_.zmp_felt - reference.zmp);
}

Stabilizer::Load Stabilizer::share(const Reference& reference) const {
  const Vector2d left = reference.X_PL.translation().head<2>(),
                 right = reference.X_PR.translation().head<2>();
  double share = reference.support == Support::left ? 1.0 : 0.0;
  if (reference.support == Support::both && !options_.distribution.enabled) share = 0.5;
  if (reference.support == Support::both && options_.distribution.enabled) {
    share = std::clamp((state_.zmp_asked - right).dot(left - right) / (left - right).squaredNorm(), 0.0, 1.0);
  }
  return {share * kWeight, (1 - share) * kWeight};
}

void Stabilizer::give_way_at_ankles(const Reference& reference, const Felt& felt, const Load& load) {
  const StabilizerOptions::AnkleAdmittance& o = options_.ankle_admittance;
  if (!o.enabled) {
    return;
  }
  const Vector2d left = reference.X_PL.translation().head<2>(),
                 right = reference.X_PR.translation().head<2>();
  // What is asked beyond the loads alone is the same shift of pressure in both soles.
  const Vector2d shift = state_.zmp_asked - (load.left * left + load.right * right) / kWeight;
  const auto give_way = [&](Vector2d& ankle, const Eigen::Isometry3d& X_PS, const Wrench& wrench,
                            double force) {
    const Vector2d inside = kSoleMin.array() + options_.tracking.sole_margin_m;
    const Vector2d pressure = (X_PS.linear().transpose() * Vector3d(shift.x(), shift.y(), 0))
                                  .head<2>()
                                  .cwiseMax(inside)
                                  .cwiseMin((kSoleMax.array() - options_.tracking.sole_margin_m).matrix());
    const Vector2d wanted(pressure.y() * force, -pressure.x() * force);
    const bool in_the_air = force == 0 && wrench.force.z() < kGroundForce;
    // A foot that rolls to the left presses on its right edge: less torque about x.
    const Vector2d rate = o.gain_rad_s_per_nm * (wrench.torque.head<2>() - wanted);
    ankle = clamped(
        integrated<Vector2d>(ankle, in_the_air ? Vector2d::Zero() : rate, in_the_air ? kAirLeak : o.leak_s),
        o.limit_rad);
  };
  give_way(left_ankle_, reference.X_PL, felt.left, load.left);
  give_way(right_ankle_, reference.X_PR, felt.right, load.right);
}

void Stabilizer::balance_forces(const Reference& reference, const Felt& felt, const Load& load) {
  const StabilizerOptions::ForceDifference& o = options_.force_difference;
  if (!o.enabled) {
    return;
  }
  const bool both = reference.support == Support::both;
  const double missing = (load.left - load.right) - (felt.left.force.z() - felt.right.force.z());
  reach_ = integrated(reach_, both ? o.gain_m_s_per_n * missing : 0.0, both ? o.leak_s : o.leak_in_swing_s);
  reach_ = std::clamp(reach_, -o.limit_m, o.limit_m);
}

void Stabilizer::carry(const Load& load) {
  const StabilizerOptions::LegCompliance& o = options_.leg_compliance;
  if (!o.enabled) {
    return;
  }
  const Vector2d loaded = Vector2d(load.left, load.right) / o.stiffness_n_m;
  compression_ += (1 - std::exp(-kPeriod / o.lag_s)) * (loaded - compression_);
}

void Stabilizer::right_the_body() {
  const StabilizerOptions::BodyAttitude& o = options_.body_attitude;
  if (!o.enabled) {
    return;
  }
  body_ = clamped(integrated<Vector2d>(body_, -o.gain_per_s * state_.tilt, o.leak_s), o.limit_rad);
}

Posture Stabilizer::corrected(const Reference& reference) const {
  Posture posture = posture_of(reference);
  posture.X_PB.linear() = reference.X_PB.linear() * turned(body_);
  // The turn leaves the centre of mass where it is.
  posture.X_PB.translation() += (reference.X_PB.linear() - posture.X_PB.linear()) * hrp2::kComInWaist;
  posture.X_PL.linear() = reference.X_PL.linear() * turned(left_ankle_);
  posture.X_PR.linear() = reference.X_PR.linear() * turned(right_ankle_);
  posture.X_PL.translation().z() -= reach_ / 2 + compression_[0];
  posture.X_PR.translation().z() -= -reach_ / 2 + compression_[1];
  return posture;
}

}  // namespace walking
