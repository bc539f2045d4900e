// The legs of HRP-2 in closed form: what numerical kinematics is compared with.
#pragma once

#include <algorithm>
#include <cmath>

#include "walking/robot.h"

namespace walking::offset_leg {

inline constexpr double kHipY = 0.060;   ///< m, hip center from the waist's origin, left positive
inline constexpr double kKneeY = 0.035;  ///< m, knee axis outwards of the hip
inline constexpr double kThigh = 0.300, kShank = 0.300;

/// The hip as seen from the ankle, turned about the ankle's roll axis into the plane of thigh and shank.
inline Eigen::Vector3d chain_from_ankle(double outwards, const Eigen::Vector3d& hip, bool& reached) {
  const double in_plane2 = hip.y() * hip.y() + hip.z() * hip.z() - kKneeY * kKneeY;
  const double in_plane = std::sqrt(std::max(0.0, in_plane2));
  const double angle = std::atan2(hip.z(), hip.y()) - outwards * std::atan2(kKneeY, in_plane);
  const Eigen::Vector3d r(hip.x(), in_plane * std::cos(angle), in_plane * std::sin(angle));
  reached = reached && in_plane2 >= 0 && r.z() > 0;
  return r;
}

/// Knee angle for a hip-ankle distance in the leg's plane; clamped to straight or fully folded.
inline double knee_angle(double distance, bool& reached) {
  const double a = kThigh, b = kShank;
  const double cosine = (distance * distance - a * a - b * b) / (2 * a * b);
  reached = reached && cosine <= 1 && cosine >= -1;
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

/// Hip yaw, roll and pitch with Rz(yaw) Rx(roll) Ry(pitch) = M.
inline Eigen::Vector3d hip_angles(const Eigen::Matrix3d& M) {
  const double yaw = std::atan2(-M(0, 1), M(1, 1));
  const double roll = std::atan2(M(2, 1), -M(0, 1) * std::sin(yaw) + M(1, 1) * std::cos(yaw));
  return {yaw, roll, std::atan2(-M(2, 0), M(2, 2))};
}

/// X_BA: the ankle (axes of the sole) in the waist. After Kajita's leg, with a lateral knee offset. The leg
/// is at its limit if the ankle is too far or too close or the hip is below the sole.
inline LegSolution closed_form(Side side, const Eigen::Isometry3d& X_BA) {
  const double outwards = side == Side::left ? 1 : -1;
  LegSolution solution{.reached = true};
  const Eigen::Vector3d hip_in_ankle = X_BA.inverse() * Eigen::Vector3d(0, outwards * kHipY, 0);
  const Eigen::Vector3d r = chain_from_ankle(outwards, hip_in_ankle, solution.reached);
  const double distance = r.norm();
  const double knee = knee_angle(distance, solution.reached);
  const double at_ankle =
      distance > 0 ? std::asin(std::clamp(kThigh * std::sin(std::numbers::pi - knee) / distance, -1.0, 1.0))
                   : 0;
  const double roll = std::atan2(r.y(), r.z());
  const double pitch = -std::atan2(r.x(), std::hypot(r.y(), r.z())) - at_ankle;
  const auto about = [](double angle, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  };
  const Eigen::Matrix3d R_hip =
      X_BA.linear() * about(-roll, Eigen::Vector3d::UnitX()) * about(-pitch - knee, Eigen::Vector3d::UnitY());
  solution.q << hip_angles(R_hip), knee, pitch, roll;
  return solution;
}

}  // namespace walking::offset_leg
