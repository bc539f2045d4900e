#include "slam/rotation.h"

#include <Eigen/Geometry>
#include <cmath>

namespace slam {
namespace {

constexpr double kSmall = 1e-5;  // rad; the next term of the series is then below 1e-17

/// sin(n/2)/n and cos(n/2).
struct HalfAngle {
  double n, sinc, cosine;
};

HalfAngle half_angle(const Eigen::Vector3d& theta) {
  const double n = theta.norm();
  if (n < kSmall) return {n, 0.5 - n * n / 48, 1 - n * n / 8};
  return {n, std::sin(n / 2) / n, std::cos(n / 2)};
}

}  // namespace

Eigen::Vector4d quaternion_exp(const Eigen::Vector3d& theta) {
  const HalfAngle half = half_angle(theta);
  return {half.cosine, half.sinc * theta.x(), half.sinc * theta.y(), half.sinc * theta.z()};
}

Matrix43d quaternion_exp_jacobian(const Eigen::Vector3d& theta) {
  const HalfAngle half = half_angle(theta);
  const double slope =
      half.n < kSmall ? -1.0 / 24 : (half.cosine / 2 - half.sinc) / (half.n * half.n);  // (d sinc/dn)/n
  Matrix43d D;
  D.row(0) = -0.5 * half.sinc * theta.transpose();
  D.bottomRows<3>() = half.sinc * Eigen::Matrix3d::Identity() + slope * theta * theta.transpose();
  return D;
}

Eigen::Vector3d quaternion_log(const Eigen::Vector4d& q) {
  const Eigen::Vector3d v = q.tail<3>();
  const double sine = v.norm();
  if (sine < kSmall) return 2 * v / q(0);
  const double sign = q(0) < 0 ? -1 : 1;
  return sign * 2 * std::atan2(sine, std::abs(q(0))) / sine * v;
}

Eigen::Vector4d quaternion_product(const Eigen::Vector4d& a, const Eigen::Vector4d& b) {
  return left_matrix(a) * b;
}

Eigen::Matrix4d left_matrix(const Eigen::Vector4d& a) {
  Eigen::Matrix4d L;
  L << a(0), -a(1), -a(2), -a(3),  //
      a(1), a(0), -a(3), a(2),     //
      a(2), a(3), a(0), -a(1),     //
      a(3), -a(2), a(1), a(0);
  return L;
}

Eigen::Matrix4d right_matrix(const Eigen::Vector4d& b) {
  Eigen::Matrix4d R;
  R << b(0), -b(1), -b(2), -b(3),  //
      b(1), b(0), b(3), -b(2),     //
      b(2), -b(3), b(0), b(1),     //
      b(3), b(2), -b(1), b(0);
  return R;
}

Eigen::Matrix3d rotation_matrix(const Eigen::Vector4d& q) {
  const double w = q(0), x = q(1), y = q(2), z = q(3);
  Eigen::Matrix3d R;
  R << w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z;
  return R;
}

Matrix34d rotated_jacobian(const Eigen::Vector4d& q, const Eigen::Vector3d& a) {
  const double w = q(0);
  const Eigen::Vector3d v = q.tail<3>();
  Matrix34d J;  // Jacobian of (w² − v·v) a + 2 (v·a) v + 2 w v × a
  J.col(0) = 2 * (w * a + v.cross(a));
  J.rightCols<3>() = 2 * (-a * v.transpose() + v * a.transpose() + v.dot(a) * Eigen::Matrix3d::Identity() -
                          w * cross_matrix(a));
  return J;
}

Matrix34d rotated_back_jacobian(const Eigen::Vector4d& q, const Eigen::Vector3d& a) {
  const Eigen::Vector4d conjugate(q(0), -q(1), -q(2), -q(3));
  Matrix34d J = rotated_jacobian(conjugate, a);
  J.rightCols<3>() *= -1;
  return J;
}

Matrix43d small_rotation_jacobian(const Eigen::Vector4d& q) { return left_matrix(q).rightCols<3>() / 2; }

Eigen::Matrix4d normalized_jacobian(const Eigen::Vector4d& q) {
  const double norm = q.norm();
  const Eigen::Vector4d unit = q / norm;
  return (Eigen::Matrix4d::Identity() - unit * unit.transpose()) / norm;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d A;
  A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return A;
}

}  // namespace slam
