// Quaternions as vectors (w, x, y, z): products, exponential, logarithm and their derivatives.
#pragma once

#include <Eigen/Core>

namespace slam {

using Matrix34d = Eigen::Matrix<double, 3, 4>;
using Matrix43d = Eigen::Matrix<double, 4, 3>;

/// Unit quaternion of a rotation vector (rad): (cos |θ|/2, θ/|θ| sin |θ|/2); finite at θ = 0.
Eigen::Vector4d quaternion_exp(const Eigen::Vector3d& theta);
/// ∂ quaternion_exp / ∂θ; finite at θ = 0.
Matrix43d quaternion_exp_jacobian(const Eigen::Vector3d& theta);

/// Rotation vector (rad, |θ| <= π) of a unit quaternion; equal for q and −q.
Eigen::Vector3d quaternion_log(const Eigen::Vector4d& q);

/// Hamilton product a × b.
Eigen::Vector4d quaternion_product(const Eigen::Vector4d& a, const Eigen::Vector4d& b);
/// ∂(a × b)/∂b.
Eigen::Matrix4d left_matrix(const Eigen::Vector4d& a);
/// ∂(a × b)/∂a.
Eigen::Matrix4d right_matrix(const Eigen::Vector4d& b);

/// R(q), which is quadratic in q and a rotation matrix if |q| = 1.
Eigen::Matrix3d rotation_matrix(const Eigen::Vector4d& q);
/// ∂(R(q) a)/∂q.
Matrix34d rotated_jacobian(const Eigen::Vector4d& q, const Eigen::Vector3d& a);
/// ∂(R(q)ᵀ a)/∂q.
Matrix34d rotated_back_jacobian(const Eigen::Vector4d& q, const Eigen::Vector3d& a);

/// ∂(q × Exp(θ))/∂θ at θ = 0, for a small rotation about the axes of C.
Matrix43d small_rotation_jacobian(const Eigen::Vector4d& q);

/// ∂(q/|q|)/∂q = (I − q̂q̂ᵀ)/|q|.
Eigen::Matrix4d normalized_jacobian(const Eigen::Vector4d& q);

/// The matrix [a]ₓ with [a]ₓ b = a × b.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a);

}  // namespace slam
