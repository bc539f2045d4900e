#include "walking/forward_kinematics.h"

#include "walking/hrp2.h"

namespace walking {

Eigen::Isometry3d sole_in_waist(Side side, const Eigen::Matrix<double, 6, 1>& q) {
  using Eigen::AngleAxisd, Eigen::Translation3d, Eigen::Vector3d;
  const double outwards = side == Side::left ? 1 : -1;
  const auto x = [](double angle) { return AngleAxisd(angle, Vector3d::UnitX()); };
  const auto y = [](double angle) { return AngleAxisd(angle, Vector3d::UnitY()); };
  const auto z = [](double angle) { return AngleAxisd(angle, Vector3d::UnitZ()); };
  return Translation3d(0, outwards * hrp2::kHipY, 0) * z(q[0]) * x(q[1]) * y(q[2]) *
         Translation3d(0, outwards * hrp2::kKneeY, -hrp2::kThigh) * y(q[3]) *
         Translation3d(0, 0, -hrp2::kShank) * y(q[4]) * x(q[5]) * Translation3d(0, 0, -hrp2::kAnkleHeight);
}

}  // namespace walking
