#include "walking/step_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace walking {

Eigen::Isometry3d sole(const FootPose& foot, double height_m) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear().topLeftCorner<2, 2>() = Eigen::Rotation2Dd(foot.yaw).toRotationMatrix();
  X.translation() << foot.position, height_m;
  return X;
}

Eigen::Isometry3d swing_foot(const FootPose& from, const FootPose& to, double elapsed, double step_height_m,
                             SwingPolynomial polynomial) {
  constexpr double kMargin = 0.05;  // of single support, vertical at either end
  const double s = std::clamp((elapsed - kMargin) / (1 - 2 * kMargin), 0.0, 1.0);
  const double along = polynomial == SwingPolynomial::quintic ? quintic_blend(s) : cubic_blend(s);
  const double up = elapsed * (1 - elapsed);
  const FootPose foot{from.position + along * (to.position - from.position),
                      from.yaw + cubic_blend(s) * (to.yaw - from.yaw)};
  return sole(foot, 16 * step_height_m * up * up);
}

WaistYaw waist_yaw(const Phase& phase, double elapsed) {
  const double turn = phase.waist_yaw_to - phase.waist_yaw_from;
  return {phase.waist_yaw_from + turn * cubic_blend(elapsed),
          turn * (6 * elapsed * (1 - elapsed)) / (phase.ticks * kPeriod)};
}

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
