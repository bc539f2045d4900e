#include "walking/kinematics.h"

namespace walking {

namespace {

void place(const Robot& robot, Side side, const ArmAngles& angles, JointVector& q) {
  const std::optional<Arm>& arm = robot.arms[static_cast<std::size_t>(side)];
  if (!arm) return;
  const auto set = [&](int joint, double about_y) {
    q[joint] = about_y * robot.joints[static_cast<std::size_t>(joint)].axis.y();
  };
  set(arm->shoulder, angles.shoulder_pitch);
  set(arm->elbow, angles.elbow);
}

}  // namespace

BodySolution inverse_kinematics(const Robot& robot, const Posture& posture, const JointVector& start) {
  BodySolution body{robot.posture};
  const auto solve = [&](Side side, const Eigen::Isometry3d& X_PS) {
    const Leg& leg = robot.leg(side);
    const LegSolution solution =
        leg_inverse_kinematics(robot, side, posture.X_PB.inverse() * X_PS, leg_angles(leg, start));
    set_leg_angles(leg, solution.q, body.q);
    return solution.reached;
  };
  body.right_reached = solve(Side::right, posture.X_PR);
  body.left_reached = solve(Side::left, posture.X_PL);
  if (posture.arms) {
    place(robot, Side::right, posture.arms->right, body.q);
    place(robot, Side::left, posture.arms->left, body.q);
  }
  return body;
}

std::optional<std::string> leg_obstacle(const Robot& robot, const BodySolution& body) {
  const auto obstacle = [&](Side side, bool reached) {
    return leg_obstacle(robot, side, {leg_angles(robot.leg(side), body.q), reached});
  };
  const auto right = obstacle(Side::right, body.right_reached);
  return right ? right : obstacle(Side::left, body.left_reached);
}

BodyPose pose_of(const Robot& robot, const Reference& reference, const JointVector& start) {
  return {reference.X_PB, inverse_kinematics(robot, reference, start).q};
}

Eigen::Isometry3d pose_between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double part) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() =
      Eigen::Quaterniond(from.linear()).slerp(part, Eigen::Quaterniond(to.linear())).toRotationMatrix();
  X.translation() = (1 - part) * from.translation() + part * to.translation();
  return X;
}

BodyMotion motion_between(const BodyPose& before, const BodyPose& after, double period) {
  const Eigen::Quaterniond from(before.X_PB.linear()), to(after.X_PB.linear());
  const Eigen::AngleAxisd turn(to * from.conjugate());
  BodyMotion motion;
  motion.pose.X_PB = pose_between(before.X_PB, after.X_PB, 0.5);
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
