#include "sim/live/recorded.h"

#include <array>
#include <cmath>

namespace sim::live {
namespace {

slam::Support support(walking::Support s) {
  if (s == walking::Support::both) return slam::Support::both;
  return s == walking::Support::left ? slam::Support::left : slam::Support::right;
}

Eigen::Vector3d support_sole(const walking::Reference& reference) {
  const Eigen::Vector3d left = reference.X_PL.translation(), right = reference.X_PR.translation();
  if (reference.support == walking::Support::both) return (left + right) / 2;
  return reference.support == walking::Support::left ? left : right;
}

Eigen::Vector3d on_ground(const Eigen::Isometry3d& X) {
  return {X.translation().x(), X.translation().y(), std::atan2(X.linear()(1, 0), X.linear()(0, 0))};
}

Eigen::Vector3d planar(const walking::FootPose& pose) {
  return {pose.position.x(), pose.position.y(), pose.yaw};
}

recording::TrueFoot true_foot(const Eigen::Isometry3d& X_WS, const Eigen::Isometry3d& X_PS, bool planned_down,
                              const physics::SoleContact& contact) {
  return {on_ground(X_WS), on_ground(X_PS), planned_down, contact.load,
          Eigen::Vector3d(contact.creep.x(), contact.creep.y(), contact.creep_yaw)};
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

std::vector<score::StepCorrection> recorded(const std::vector<walking::StepCorrection>& corrections) {
  std::vector<score::StepCorrection> steps;
  for (const walking::StepCorrection& c : corrections)
    steps.push_back({std::chrono::nanoseconds(std::llround(1e9 * c.decided_s)), c.correction.position.x(),
                     c.correction.position.y(), c.correction.yaw, c.desired.side == walking::Side::left,
                     planar(c.desired.pose), planar(c.expected)});
  return steps;
}

slam::BodyReading recorded(std::chrono::nanoseconds t, const walking::SensorReadings& readings) {
  const auto wrench = [](const walking::Wrench& w) { return slam::BodyReading::Wrench{w.force, w.torque}; };
  return {t, readings.q, wrench(readings.left), wrench(readings.right)};
}

recording::TrueMotion true_motion(const physics::World& world) {
  return {world.time(), world.X_WG(), world.v_WG()};
}

recording::TrueFeet true_feet(physics::World& world, const walking::Reference& plan) {
  const auto [left, right] = world.sole_contacts_since_last();
  return {world.time(), true_foot(world.X_WL(), plan.X_PL, plan.support != walking::Support::right, left),
          true_foot(world.X_WR(), plan.X_PR, plan.support != walking::Support::left, right),
          world.torque_limited_since_last()};
}

scenario::Ending ending(physics::Condition condition) {
  using enum scenario::Ending;
  constexpr std::array kEndings{completed, fell, collided, failed};  // in the order of the conditions
  return kEndings[static_cast<std::size_t>(condition)];
}

}  // namespace sim::live
