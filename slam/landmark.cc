#include "slam/landmark.h"

namespace slam {

Direction direction(const LandmarkKind& kind, const Parameters& y, const Eigen::Vector3d& r,
                    const Eigen::Vector4d& q) {
  const Eigen::Matrix3d R_CW = rotation_matrix(q).transpose();
  Eigen::Vector3d h_W = y.head<3>() - r;
  double weight = 1;
  Direction d;
  if (std::holds_alternative<Point>(kind)) {
    d.J_y = R_CW;
  } else if (const auto* line = std::get_if<SemiInfiniteLine>(&kind)) {
    const double depth = depth_moments(line->particles).mean_m;
    d.J_y.resize(3, 6);
    d.J_y << R_CW, depth * R_CW;
    h_W += depth * y.segment<3>(3);
  } else {
    weight = y(5);
    d.J_y.resize(3, 6);
    d.J_y << weight * R_CW, R_CW * bearing_jacobian(y(3), y(4)), R_CW * h_W;
    h_W = weight * h_W + bearing(y(3), y(4));
  }
  d.h_C = R_CW * h_W;
  d.J_r = -weight * R_CW;
  d.J_q = rotated_back_jacobian(q, h_W);
  return d;
}

Eigen::Vector3d position(const LandmarkKind& kind, const Parameters& y) {
  if (std::holds_alternative<Point>(kind)) return y;
  if (const auto* line = std::get_if<SemiInfiniteLine>(&kind))
    return y.head<3>() + depth_moments(line->particles).mean_m * y.segment<3>(3);
  return inverse_depth_position(y);
}

Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6> position_jacobian(const LandmarkKind& kind,
                                                                    const Parameters& y) {
  if (std::holds_alternative<Point>(kind)) return Eigen::Matrix3d::Identity();
  if (const auto* line = std::get_if<SemiInfiniteLine>(&kind)) {
    Matrix36d J;
    J << Eigen::Matrix3d::Identity(), depth_moments(line->particles).mean_m * Eigen::Matrix3d::Identity();
    return J;
  }
  return inverse_depth_position_jacobian(y);
}

Eigen::Matrix3d position_covariance(const State& state, const Landmark& landmark) {
  const int at = landmark.at, size = landmark.size();
  const auto J = position_jacobian(landmark.kind, landmark.parameters(state));
  return J * state.storage_P.block(at, at, size, size).selfadjointView<Eigen::Lower>() * J.transpose();
}

}  // namespace slam
