#include "walking/arm_momentum.h"

#include <array>
#include <utility>

#include "walking/hrp2.h"

namespace walking {
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
