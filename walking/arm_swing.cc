#include "walking/arm_swing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "walking/hrp2.h"

namespace walking {
namespace {

constexpr double kSegment = 0.25;  // m, upper arm and forearm
constexpr int kRightArm = 16, kLeftArm = 23, kElbow = 3;

/// Hand below the shoulder in half-sitting, m: shoulder pitch 15 degrees, elbow -30 degrees.
double hand_below_shoulder() { return 2 * kSegment * std::cos(15 * std::numbers::pi / 180); }

/// Half of what the straight arm reaches ahead at that height, for a foot 0.2 m away.
double gain() {
  return 0.5 * std::sqrt(kSegment * kSegment - std::pow(hand_below_shoulder() - kSegment, 2)) / 0.2;
}

double foot_ahead(const Eigen::Isometry3d& X_PB, const Eigen::Isometry3d& X_PS) {
  return (X_PB.inverse() * X_PS).translation().x() - hrp2::kAnkleX;
}

void place(const ArmAngles& angles, int first_joint, JointVector& q) {
  q(first_joint) = angles.shoulder_pitch;
  q(first_joint + kElbow) = angles.elbow;
}

}  // namespace

ArmAngles arm_swing(double foot_ahead_m) {
  const double x = -gain() * foot_ahead_m, z = hand_below_shoulder();
  const double reach = std::min(std::hypot(x, z), 2 * kSegment);
  const double elbow = std::acos(1 - reach * reach / (2 * kSegment * kSegment)) - std::numbers::pi;
  const double at_shoulder = std::asin(kSegment * std::sin(std::numbers::pi + elbow) / reach);
  return {at_shoulder - std::atan2(x, z), elbow};
}

void swing_arms(const Posture& posture, JointVector& q) {
  place(arm_swing(foot_ahead(posture.X_PB, posture.X_PR)), kRightArm, q);
  place(arm_swing(foot_ahead(posture.X_PB, posture.X_PL)), kLeftArm, q);
}

}  // namespace walking
