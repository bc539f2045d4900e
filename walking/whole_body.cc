#include "walking/whole_body.h"

#include "walking/inverse_kinematics.h"

namespace walking {

BodyPose pose_of(const Reference& reference) {
  return {reference.X_PB, inverse_kinematics(posture_of(reference)).q};
}

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
