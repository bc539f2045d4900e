#include "walking/arms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "walking/hrp2.h"

namespace walking {
namespace {

constexpr double kSegment = hrp2::kUpperArm;

/// Distance of the hand below the shoulder in half-sitting, m: the forearm points as far ahead of the
/// vertical as the upper arm points back.
double hand_below_shoulder() { return 2 * kSegment * std::cos(ArmAngles{}.shoulder_pitch); }

/// Half of what the straight arm reaches ahead at that height, for a foot 0.2 m away.
double gain() {
  return 0.5 * std::sqrt(kSegment * kSegment - std::pow(hand_below_shoulder() - kSegment, 2)) / 0.2;
}

double foot_ahead(const Eigen::Isometry3d& X_PB, const Eigen::Isometry3d& X_PS) {
  return (X_PB.inverse() * X_PS).translation().x() - hrp2::kAnkleX;
}

}  // namespace

ArmAngles arm_swing(double foot_ahead_m) {
  const double x = -gain() * foot_ahead_m, z = hand_below_shoulder();
  const double distance = std::min(std::hypot(x, z), 2 * kSegment);
  const double elbow = std::acos(1 - distance * distance / (2 * kSegment * kSegment)) - std::numbers::pi;
  const double at_shoulder = std::asin(kSegment * std::sin(std::numbers::pi + elbow) / distance);
  return {at_shoulder - std::atan2(x, z), elbow};
}

Arms arm_swing(const Reference& reference) {
  return {arm_swing(foot_ahead(reference.X_PB, reference.X_PR)),
          arm_swing(foot_ahead(reference.X_PB, reference.X_PL))};
}

namespace {

constexpr double kReturnTime = 0.5;  // s, time constant of the arms' return to half-sitting
constexpr double kLargestSwing =
    0.7;  // rad from half-sitting; HRP-2's shoulder reaches 45 degrees further back

constexpr std::array kShoulders{hrp2::kRightArm, hrp2::kLeftArm};

Arms arms_swung_by(const Eigen::Vector2d& angles) {
  Arms arms;
  arms.right.shoulder_pitch += angles(0);
  arms.left.shoulder_pitch += angles(1);
  return arms;
}

}  // namespace

/// The row A of L_z = A dq for right and left shoulder.
Eigen::Vector2d ArmMomentum::yaw_momentum_of_shoulders(const BodyPose& pose) const {
  Eigen::Vector2d A;
  for (int i = 0; i < 2; ++i) {
    BodyMotion alone{pose};
    alone.dq(kShoulders[i]) = 1;
    A(i) = model_(alone).angular.z();
  }
  return A;
}

Arms ArmMomentum::operator()(const Reference& reference) {
  Reference now = reference;
  now.arms = last_.arms = arms_swung_by(swing_);
  if (std::exchange(started_, true)) {
    const BodyMotion motion = motion_between(pose_of(last_), pose_of(now));
    const Eigen::Vector2d A = yaw_momentum_of_shoulders(motion.pose);
    const Eigen::Vector2d rate = -A * (model_(motion).angular.z() / A.squaredNorm()) - swing_ / kReturnTime;
    swing_ = (swing_ + kPeriod * rate).cwiseMax(-kLargestSwing).cwiseMin(kLargestSwing);
  }
  last_ = reference;
  return arms_swung_by(swing_);
}

}  // namespace walking
