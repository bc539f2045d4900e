#include "walking/inverse_kinematics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "walking/hrp2.h"

namespace walking {
namespace {

constexpr double kPi = std::numbers::pi;

/// The hip as seen from the ankle, turned about the ankle's roll axis into the plane of thigh and shank.
Eigen::Vector3d chain_from_ankle(double outwards, const Eigen::Vector3d& hip, bool& reached) {
  const double in_plane2 = hip.y() * hip.y() + hip.z() * hip.z() - hrp2::kKneeY * hrp2::kKneeY;
  const double in_plane = std::sqrt(std::max(0.0, in_plane2));
  const double angle = std::atan2(hip.z(), hip.y()) - outwards * std::atan2(hrp2::kKneeY, in_plane);
  const Eigen::Vector3d r(hip.x(), in_plane * std::cos(angle), in_plane * std::sin(angle));
  reached = reached && in_plane2 >= 0 && r.z() > 0;
  return r;
}

/// Knee angle for a hip-ankle distance in the leg's plane; clamped to straight or fully folded.
double knee_angle(double distance, bool& reached) {
  const double a = hrp2::kThigh, b = hrp2::kShank;
  const double cosine = (distance * distance - a * a - b * b) / (2 * a * b);
  reached = reached && cosine <= 1 && cosine >= -1;
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

Eigen::Matrix3d about_x(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
}
Eigen::Matrix3d about_y(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
}

/// Hip yaw, roll and pitch with Rz(yaw) Rx(roll) Ry(pitch) = M.
Eigen::Vector3d hip_angles(const Eigen::Matrix3d& M) {
  const double yaw = std::atan2(-M(0, 1), M(1, 1));
  const double roll = std::atan2(M(2, 1), -M(0, 1) * std::sin(yaw) + M(1, 1) * std::cos(yaw));
  return {yaw, roll, std::atan2(-M(2, 0), M(2, 2))};
}

Eigen::Isometry3d ankle_above(const Eigen::Isometry3d& X_PS) {
  return X_PS * Eigen::Translation3d(0, 0, hrp2::kAnkleHeight);
}

void place(const ArmAngles& angles, int shoulder_pitch, JointVector& q) {
  q(shoulder_pitch) = angles.shoulder_pitch;
  q(shoulder_pitch + hrp2::kElbow) = angles.elbow;
}

}  // namespace

LegSolution leg_inverse_kinematics(Side side, const Eigen::Isometry3d& X_BA) {
  const double outwards = side == Side::left ? 1 : -1;
  LegSolution solution;
  const Eigen::Vector3d hip_in_ankle = X_BA.inverse() * Eigen::Vector3d(0, outwards * hrp2::kHipY, 0);
  const Eigen::Vector3d r = chain_from_ankle(outwards, hip_in_ankle, solution.reached);
  const double distance = r.norm();
  const double knee = knee_angle(distance, solution.reached);
  const double at_ankle =
      distance > 0 ? std::asin(std::clamp(hrp2::kThigh * std::sin(kPi - knee) / distance, -1.0, 1.0)) : 0;
  const double roll = std::atan2(r.y(), r.z());
  const double pitch = -std::atan2(r.x(), std::hypot(r.y(), r.z())) - at_ankle;
  solution.q << hip_angles(X_BA.linear() * about_x(-roll) * about_y(-pitch - knee)), knee, pitch, roll;
  return solution;
}

BodySolution inverse_kinematics(const Posture& posture) {
  const Eigen::Isometry3d X_BP = posture.X_PB.inverse();
  const LegSolution right = leg_inverse_kinematics(Side::right, X_BP * ankle_above(posture.X_PR));
  const LegSolution left = leg_inverse_kinematics(Side::left, X_BP * ankle_above(posture.X_PL));
  BodySolution body{hrp2::half_sitting(), left.reached, right.reached};
  body.q.segment<6>(0) = right.q;
  body.q.segment<6>(6) = left.q;
  place(posture.arms.right, hrp2::kRightArm, body.q);
  place(posture.arms.left, hrp2::kLeftArm, body.q);
  return body;
}

}  // namespace walking
