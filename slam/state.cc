#include "slam/state.h"

namespace slam {

Eigen::Isometry3d State::X_WC() const {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = rotation_matrix(orientation());
  X.translation() = position();
  return X;
}

RobotVector robot_null_yaw(const RobotVector& x) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  RobotVector n = RobotVector::Zero();
  n.segment<3>(kPosition) = up.cross(x.segment<3>(kPosition));
  n.segment<4>(kOrientation) =
      0.5 * quaternion_product(Eigen::Vector4d(0, 0, 0, 1), x.segment<4>(kOrientation));
  n.segment<3>(kVelocity) = up.cross(x.segment<3>(kVelocity));
  return n;
}

Matrix43d small_rotation_jacobian(const Eigen::Vector4d& q) { return left_matrix(q).rightCols<3>() / 2; }

}  // namespace slam
