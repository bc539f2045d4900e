#include "walking/leg_odometry.h"

#include <cmath>

#include "walking/kinematics.h"

namespace walking {
namespace {

constexpr double kOtherCarries = 1.1;  // ratio of the loads: feet that share the load do not take turns
constexpr double kSettling_s = 0.1;    // time constant of a landed sole until it lies flat

/// The sole's pose on the floor: its place and heading.
Eigen::Isometry3d flat(const Eigen::Isometry3d& X) {
  Eigen::Isometry3d on_floor = Eigen::Isometry3d::Identity();
  on_floor.linear() =
      Eigen::AngleAxisd(std::atan2(X(1, 0), X(0, 0)), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  on_floor.translation() << X.translation().head<2>(), 0;
  return on_floor;
}

/// A sole that has landed, a tick later.
Eigen::Isometry3d settled(const Eigen::Isometry3d& X) {
  static const double part = 1 - std::exp(-kPeriod / kSettling_s);
  const Eigen::Isometry3d end = flat(X);
  Eigen::Isometry3d now = Eigen::Isometry3d::Identity();
  const Eigen::Quaterniond q_OS =
      Eigen::Quaterniond(X.linear()).normalized();  // or rounding errors would grow
  now.linear() = q_OS.slerp(part, Eigen::Quaterniond(end.linear())).normalized().toRotationMatrix();
  now.translation() = X.translation() + part * (end.translation() - X.translation());
  return now;
}

}  // namespace

Eigen::Isometry3d measured_sole_in_base(const Robot& robot, Side side, const LegVector& q,
                                        const Wrench& wrench) {
  using Eigen::Vector3d;
  const Leg& leg = robot.leg(side);
  const Vector3d ankle = leg.ankle(), torque = wrench.torque - ankle.cross(wrench.force);  // about the ankle
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  Vector3d moved = Vector3d::Zero();
  for (const Spring& spring : leg.bush)
    if (spring.turns)
      turned = turned * Eigen::AngleAxisd(spring.axis.dot(torque) / spring.stiffness, spring.axis);
    else
      moved += spring.axis.dot(wrench.force) / spring.stiffness * spring.axis;
  Eigen::Isometry3d deflection = Eigen::Isometry3d::Identity();  // of the sole
  deflection.linear() = turned;
  deflection.translation() = ankle + moved - turned * ankle;
  return sole_in_base(robot, side, q) * deflection;
}

Eigen::Isometry3d floor_under_sole(const Leg& leg, const Wrench& lagged) {
  using Eigen::Vector3d;
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  if (!(leg.pad_stiffness.minCoeff() > 0)) return X_SF;
  Vector3d middle = Vector3d::Zero();
  middle.head<2>() = (leg.sole_min + leg.sole_max) / 2;
  const Vector3d torque = lagged.torque - middle.cross(lagged.force);
  X_SF.linear() = (Eigen::AngleAxisd(torque.y() / leg.pad_stiffness.y(), Vector3d::UnitY()) *
                   Eigen::AngleAxisd(torque.x() / leg.pad_stiffness.x(), Vector3d::UnitX()))
                      .toRotationMatrix();
  X_SF.translation() = middle - X_SF.linear() * middle;
  return X_SF;
}

Eigen::Isometry3d LegOdometry::X_BS(Side side, const JointVector& q) const {
  const auto& [now, lagged] = wrenches_[static_cast<std::size_t>(side)];
  const Leg& leg = robot_.leg(side);
  return measured_sole_in_base(robot_, side, leg_angles(leg, q), now) * floor_under_sole(leg, lagged);
}

void LegOdometry::add(const SensorReadings& readings) {
  for (const Side side : {Side::right, Side::left}) {
    auto& [now, lagged] = wrenches_[static_cast<std::size_t>(side)];
    now = side == Side::left ? readings.left : readings.right;
    const double lag_s = robot_.leg(side).pad_lag_s;
    const double part = started_ && lag_s > 0 ? 1 - std::exp(-kPeriod / lag_s) : 1;
    lagged.force += part * (now.force - lagged.force);
    lagged.torque += part * (now.torque - lagged.torque);
  }
  const double left = readings.left.force.z(), right = readings.right.force.z();
  if (!started_) {
    carrying_ = left > right ? Side::left : Side::right;
    X_OS_ = flat(X_OB_start_ * X_BS(carrying_, readings.q));
    started_ = true;
    return;
  }
  const bool carries_left = carrying_ == Side::left;
  if ((carries_left ? right : left) <= kOtherCarries * (carries_left ? left : right)) {
    X_OS_ = settled(X_OS_);
    return;
  }
  const Side other = carries_left ? Side::right : Side::left;
  X_OS_ = X_OS_ * X_BS(carrying_, readings.q).inverse() * X_BS(other, readings.q);
  carrying_ = other;
}

LegOdometry::Motion LegOdometry::motion(const JointVector& q) const {
  return {X_OS_ * X_BS(carrying_, q).inverse(), X_OS_.translation()};
}

}  // namespace walking
