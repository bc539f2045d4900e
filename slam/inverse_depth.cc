#include "slam/inverse_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slam {
namespace {

constexpr double kLeastInverseDepth = 0.01;  // 1/m, of positions

/// ∂(θ, φ)/∂h of θ = atan2(h_y, h_x), φ = atan2(h_z, √(h_x² + h_y²)).
Matrix23d angles_jacobian(const Eigen::Vector3d& h) {
  const double level2 = h.head<2>().squaredNorm(), level = std::sqrt(level2), all2 = h.squaredNorm();
  Matrix23d J;
  J << -h.y() / level2, h.x() / level2, 0, -h.x() * h.z() / (level * all2), -h.y() * h.z() / (level * all2),
      level / all2;
  return J;
}

}  // namespace

Eigen::Vector3d bearing(double theta, double phi) {
  return {std::cos(phi) * std::cos(theta), std::cos(phi) * std::sin(theta), std::sin(phi)};
}

Matrix32d bearing_jacobian(double theta, double phi) {
  Matrix32d J;
  J << -std::cos(phi) * std::sin(theta), -std::sin(phi) * std::cos(theta),  //
      std::cos(phi) * std::cos(theta), -std::sin(phi) * std::sin(theta),    //
      0, std::cos(phi);
  return J;
}

LandmarkInitialisation initialise_inverse_depth(const RobotVector& x, const Ray& ray, double sigma_px,
                                                const Eigen::Vector2d& displacement,
                                                const Options::Depth& options) {
  const Eigen::Vector4d q = x.segment<4>(kOrientation);
  const Eigen::Matrix3d R_WC = rotation_matrix(q);
  const Eigen::Vector3d h_W = R_WC * ray.h;
  const Matrix23d J_angles = angles_jacobian(h_W);
  LandmarkInitialisation landmark{Vector6d::Zero(), Eigen::Matrix<double, 6, kRobot>::Zero(),
                                  Matrix6d::Zero()};
  landmark.y << x.segment<3>(kPosition), std::atan2(h_W.y(), h_W.x()),
      std::atan2(h_W.z(), h_W.head<2>().norm()), options.inverse_1_m;
  landmark.J_robot.block<3, 3>(0, kPosition).setIdentity();
  landmark.J_robot.block<2, 4>(3, kOrientation) = J_angles * rotated_jacobian(q, ray.h);
  const Eigen::Matrix2d J_pixel = J_angles * R_WC * ray.J;
  landmark.noise.block<2, 2>(3, 3) = sigma_px * sigma_px * J_pixel * J_pixel.transpose();
  landmark.distortion.segment<2>(3) = -J_pixel * displacement;
  landmark.noise(5, 5) = options.sigma_inverse_1_m * options.sigma_inverse_1_m;
  return landmark;
}

Eigen::Vector3d inverse_depth_position(const Vector6d& y) {
  return y.head<3>() + bearing(y(3), y(4)) / std::max(y(5), kLeastInverseDepth);
}

Matrix36d inverse_depth_position_jacobian(const Vector6d& y) {
  const double rho = std::max(y(5), kLeastInverseDepth);
  Matrix36d J;
  J << Eigen::Matrix3d::Identity(), bearing_jacobian(y(3), y(4)) / rho, -bearing(y(3), y(4)) / (rho * rho);
  return J;
}

double linearity_index(const Vector6d& y, double sigma_rho, const Eigen::Vector3d& r) {
  if (y(5) <= kLeastInverseDepth) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d p = inverse_depth_position(y);
  const Eigen::Vector3d from_now = p - r, from_anchor = p - y.head<3>();
  const double d1 = from_now.norm();
  const double cosine = from_now.dot(from_anchor) / (d1 * from_anchor.norm());
  return 4 * sigma_rho / (y(5) * y(5)) * std::abs(cosine) / d1;
}

}  // namespace slam
