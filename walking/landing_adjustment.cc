#include "walking/landing_adjustment.h"

#include <algorithm>
#include <cmath>

#include "walking/kinematics.h"
#include "walking/timeline.h"

namespace walking {
namespace {

using Eigen::Vector2d;

constexpr double kEarly = 0.6;     // fraction of the swing; a foot that is loaded after that has touched down
constexpr double kContact = 0.15;  // fraction of the weight; a foot with more load is in contact
constexpr double kSettled_s = 0.02;   // before touch-down; by then the foothold is in its place
constexpr double kNegligible = 1e-3;  // m, outside the area of steps

}  // namespace

LandingAdjustment::LandingAdjustment(const Robot& robot, const StabilizerOptions::LandingAdjustment& options)
    : robot_(robot), options_(options), omega_(std::sqrt(kGravity / robot.com_height())) {}

Reference LandingAdjustment::shifted(Reference planned) const {
  planned.X_PL.translation().head<2>() += left_;
  planned.X_PR.translation().head<2>() += right_;
  planned.X_PB.translation().head<2>() += frame_;
  planned.com.head<2>() += frame_;
  planned.zmp += frame_;
  planned.zmp_reference += frame_;
  planned.frame_shift = frame_;
  return planned;
}

Reference LandingAdjustment::adjust(const Reference& planned, const StabilizerState& state,
                                    const SensorReadings& readings) {
  if (!options_.enabled) return planned;
  const bool swings = planned.support != Support::both;
  if (swings) {
    if (!swung_) has_touched_down_ = false;
    move_foothold(planned, state, readings);
  } else if (swung_) {  // touch-down
    from_ = frame_, to_ = foot(*swung_), progress_ = 0;
  }
  swung_ = swings ? std::optional(planned.swing.side) : std::nullopt;
  progress_ = std::min(1.0, progress_ + kPeriod / options_.shift_s);
  frame_ = from_ + cubic_blend(progress_) * (to_ - from_);
  return shifted(planned);
}

/// The desired shift of the landing relative to the shift of the frame, in P.
Vector2d LandingAdjustment::wanted(const Reference& planned, const StabilizerState& state) const {
  const Reference::Swing& swing = planned.swing;
  const Eigen::Rotation2Dd heading(on_floor(swing.X_PS).yaw);
  const Vector2d error = state.com_error + state.com_velocity_error / omega_;
  Vector2d shift = heading.inverse() * error * std::exp(options_.growth_fraction * omega_ * swing.left_s);
  for (double& part : shift)
    part = std::copysign(std::clamp(std::abs(part) - options_.dead_zone_m, 0.0, options_.largest_m), part);
  const double outwards = swing.side == Side::left ? 1 : -1;
  shift.y() = outwards * std::max(outwards * shift.y(), -options_.largest_inwards_m);
  return heading * shift;
}

/// Moves the foothold toward the desired place, as fast as needed to arrive in the remaining time.
void LandingAdjustment::move_foothold(const Reference& planned, const StabilizerState& state,
                                      const SensorReadings& readings) {
  const Reference::Swing& swing = planned.swing;
  const Wrench& wrench = swing.side == Side::left ? readings.left : readings.right;
  has_touched_down_ |= swing.elapsed > kEarly && wrench.force.z() > kContact * robot_.mass * kGravity;
  if (has_touched_down_) return;
  const Vector2d before = foot(swing.side), offset = wanted(planned, state);
  const double part = std::min(1.0, kPeriod / std::max(kPeriod, swing.left_s - kSettled_s));
  for (const double share : {1.0, 0.5, 0.25, 0.0}) {
    foot(swing.side) = before + part * (to_ + share * offset - before);
    if (share == 0 || offset.isZero() || allows(planned, to_ + share * offset, readings.q)) return;
  }
}

bool LandingAdjustment::allows(const Reference& planned, const Vector2d& shift, const JointVector& q) const {
  const Reference::Swing& swing = planned.swing;
  FootPose standing = on_floor(swing.side == Side::left ? planned.X_PR : planned.X_PL);
  standing.position += foot(other(swing.side));
  const auto outside = [&](const Vector2d& by) {
    FootPose landing = on_floor(swing.X_PS);
    landing.position += by;
    return distance_outside(robot_, standing, {swing.side, landing});
  };
  // A landing that is already outside is not moved farther out.
  return outside(shift) <= std::max(kNegligible, outside(to_)) &&
         !leg_obstacle(robot_, inverse_kinematics(robot_, shifted(planned), q));
}

}  // namespace walking
