#include "walking/arm_swing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace walking
