#include "walking/kinematics.h"

#include <algorithm>
#include <cmath>

namespace walking {

namespace {

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

constexpr std::array kJointNames{"hip yaw", "hip roll", "hip pitch", "knee", "ankle pitch", "ankle roll"};

std::optional<std::string> obstacle_of(Side side, const Eigen::Matrix<double, 6, 1>& q, bool reached) {
  const std::string leg = side == Side::left ? "left" : "right";
  if (!reached) return "the " + leg + " foot is out of the leg's reach";
  const LegLimits limits = leg_limits(side);
  for (int i = 0; i < 6; ++i) {
    if (q(i) >= limits.lowest(i) && q(i) <= limits.highest(i)) continue;
    return "the " + leg + " " + kJointNames[i] + " would have to turn to " +
           std::to_string(q(i) * 180 / std::numbers::pi) + " degrees";
  }
  return std::nullopt;
}

}  // namespace

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

Eigen::Matrix3d chest_in_waist(const JointVector& q) {
  return (Eigen::AngleAxisd(q[hrp2::kChestYaw], Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(q[hrp2::kChestPitch], Eigen::Vector3d::UnitY()))
      .toRotationMatrix();
}

LegSolution leg_inverse_kinematics(Side side, const Eigen::Isometry3d& X_BA) {
  const double outwards = side == Side::left ? 1 : -1;
  LegSolution solution{.reached = true};
  const Eigen::Vector3d hip_in_ankle = X_BA.inverse() * Eigen::Vector3d(0, outwards * hrp2::kHipY, 0);
  const Eigen::Vector3d r = chain_from_ankle(outwards, hip_in_ankle, solution.reached);
  const double distance = r.norm();
  const double knee = knee_angle(distance, solution.reached);
  const double at_ankle =
      distance > 0
          ? std::asin(std::clamp(hrp2::kThigh * std::sin(std::numbers::pi - knee) / distance, -1.0, 1.0))
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

LegLimits leg_limits(Side side) {
  LegLimits right;
  right.lowest << -45, -35, -125, -2, -75, -20;
  right.highest << 30, 20, 42, 150, 42, 35;
  right.lowest *= std::numbers::pi / 180;
  right.highest *= std::numbers::pi / 180;
  if (side == Side::right) return right;
  LegLimits left = right;
  for (const int mirrored : {0, 1, 5}) {
    left.lowest(mirrored) = -right.highest(mirrored);
    left.highest(mirrored) = -right.lowest(mirrored);
  }
  return left;
}

std::optional<std::string> leg_obstacle(const BodySolution& body) {
  auto obstacle = obstacle_of(Side::right, body.q.segment<6>(0), body.right_reached);
  if (!obstacle) obstacle = obstacle_of(Side::left, body.q.segment<6>(6), body.left_reached);
  return obstacle;
}

BodyPose pose_of(const Reference& reference) { return {reference.X_PB, inverse_kinematics(reference).q}; }

BodyMotion motion_between(const BodyPose& before, const BodyPose& after, double period) {
  const Eigen::Quaterniond from(before.X_PB.linear()), to(after.X_PB.linear());
  const Eigen::AngleAxisd turn(to * from.conjugate());
  BodyMotion motion;
  motion.pose.X_PB.linear() = from.slerp(0.5, to).toRotationMatrix();
  motion.pose.X_PB.translation() = (before.X_PB.translation() + after.X_PB.translation()) / 2;
  motion.pose.q = (before.q + after.q) / 2;
  motion.v = (after.X_PB.translation() - before.X_PB.translation()) / period;
  motion.w = turn.axis() * (turn.angle() / period);
  motion.dq = (after.q - before.q) / period;
  return motion;
}

Eigen::Vector2d multibody_zmp(const BodyMomentum& before, const BodyMomentum& after, double period) {
  const auto about_origin = [](const BodyMomentum& m) {
    return Eigen::Vector3d(m.angular + m.com.cross(m.linear));
  };
  const Eigen::Vector3d com = (before.com + after.com) / 2;
  const Eigen::Vector3d force = (after.linear - before.linear) / period;
  const Eigen::Vector3d moment = (about_origin(after) - about_origin(before)) / period;
  const double weight = before.mass * kGravity;
  return Eigen::Vector2d(weight * com.x() - moment.y(), weight * com.y() + moment.x()) / (weight + force.z());
}

}  // namespace walking
