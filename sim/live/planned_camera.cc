#include "sim/live/planned_camera.h"

namespace sim::live {
namespace {

slam::Support support(walking::Support s) {
  switch (s) {
    case walking::Support::left:
      return slam::Support::left;
    case walking::Support::right:
      return slam::Support::right;
    case walking::Support::both:
      break;
  }
  return slam::Support::both;
}

Eigen::Vector3d support_sole(const walking::Reference& reference) {
  const Eigen::Vector3d left = reference.X_PL.translation(), right = reference.X_PR.translation();
  switch (reference.support) {
    case walking::Support::left:
      return left;
    case walking::Support::right:
      return right;
    case walking::Support::both:
      break;
  }
  return (left + right) / 2;
}

}  // namespace

Eigen::Isometry3d planned_waist(const walking::Reference& from, const walking::Reference& to, double t_s) {
  const double part = (t_s - from.t_s) / walking::kPeriod;
  Eigen::Isometry3d X_PB;
  X_PB.linear() =
      Eigen::Quaterniond(from.X_PB.linear()).slerp(part, Eigen::Quaterniond(to.X_PB.linear())).matrix();
  X_PB.translation() = (1 - part) * from.X_PB.translation() + part * to.X_PB.translation();
  X_PB.makeAffine();
  return X_PB;
}

slam::PlannedMotion planned_motion(const walking::Reference& from, const walking::Reference& to, double t_s,
                                   const Eigen::Isometry3d& X_BC) {
  slam::PlannedMotion motion;
  motion.X_PC = planned_waist(from, to, t_s) * X_BC;
  const Eigen::Matrix3d R_CP = motion.X_PC.linear().transpose();
  const Eigen::Vector3d w_PB_P = from.waist_yaw_rate * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d p_BC_P = from.X_PB.linear() * X_BC.translation();
  motion.v_PC_C = R_CP * (from.waist_velocity + w_PB_P.cross(p_BC_P));
  motion.w_PC_C = R_CP * w_PB_P;
  motion.support = support(from.support);
  motion.p_CF = motion.X_PC.inverse() * support_sole(from);
  return motion;
}

slam::LegMotion leg_motion(const walking::LegOdometry& legs, const walking::JointVector& q,
                           const Eigen::Isometry3d& X_BC) {
  const auto [X_OB, p_OS] = legs.motion(q);
  const Eigen::Isometry3d X_OC = X_OB * X_BC;
  return {X_OC, X_OC.inverse() * p_OS};
}

}  // namespace sim::live
