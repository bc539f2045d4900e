#include "walking/swing_foot.h"

#include <algorithm>

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
          turn * cubic_blend_rate(elapsed) / (phase.ticks * kPeriod)};
}

}  // namespace walking
