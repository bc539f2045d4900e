#include "walking/leg_odometry.h"

#include <cmath>

#include "walking/kinematics.h"

namespace walking {
namespace {

constexpr double kOtherCarries = 1.1;  // ratio of the loads; feet that share the load do not alternate
constexpr double kSettling_s = 0.1;    // time constant of a landed sole until it lies flat
// Fraction of the total load: loads computed from joint torques can be this large for a swinging leg.
constexpr double kCarries = 0.2;
// A landing foot slides while it already carries load, and a foot that lifts off may drag. A point of contact
// counts 1/e if it moves at this speed according to the accelerometer. The accelerometer is less sure the
// longer no foot has been at rest, and it counts as much as a part of the load.
constexpr double kSliding_m_s = 0.012, kLessSure_m_s2 = 0.3, kPredicted = 0.5;
// If no foot has been at rest for longer, the predicted velocity is wrong, or the robot hangs.
constexpr double kCoasting_s = 0.3;
// Time constant with which the accelerometer corrects the tilt. It spans many strides, since the
// accelerometer also feels the sway.
constexpr double kLeveling_s = 20;

/// The sole's place and heading on the floor, as a pose.
Eigen::Isometry3d flat(const Eigen::Isometry3d& X) {
  Eigen::Isometry3d on_floor = Eigen::Isometry3d::Identity();
  on_floor.linear() =
      Eigen::AngleAxisd(std::atan2(X(1, 0), X(0, 0)), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  on_floor.translation() << X.translation().head<2>(), 0;
  return on_floor;
}

/// Returns the fraction of its remaining distance to the floor that a landed sole settles in one tick.
double settling() {
  static const double part = 1 - std::exp(-kPeriod / kSettling_s);
  return part;
}

/// Returns the fraction of its distance to the new rest position that a damped spring moves in one tick.
double yields(double lag_s) { return lag_s > 0 ? 1 - std::exp(-kPeriod / lag_s) : 1; }

/// The pose of a landed sole one tick later.
Eigen::Isometry3d settled(const Eigen::Isometry3d& X) {
  const double part = settling();
  const Eigen::Isometry3d end = flat(X);
  Eigen::Isometry3d now = Eigen::Isometry3d::Identity();
  const Eigen::Quaterniond q_OS =
      Eigen::Quaterniond(X.linear()).normalized();  // or rounding errors would grow
  now.linear() = q_OS.slerp(part, Eigen::Quaterniond(end.linear())).normalized().toRotationMatrix();
  now.translation() = X.translation() + part * (end.translation() - X.translation());
  return now;
}

}  // namespace

std::vector<double> deflections(const Leg& leg, const Wrench& wrench) {
  const Eigen::Vector3d torque = wrench.torque - leg.ankle().cross(wrench.force);  // about the ankle
  std::vector<double> bush;
  for (const Spring& spring : leg.bush)
    bush.push_back(spring.axis.dot(spring.turns ? torque : wrench.force) / spring.stiffness);
  return bush;
}

Eigen::Isometry3d measured_sole_in_base(const Robot& robot, Side side, const LegVector& q,
                                        const std::vector<double>& bush) {
  using Eigen::Vector3d;
  const Leg& leg = robot.leg(side);
  const Vector3d ankle = leg.ankle();
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  Vector3d moved = Vector3d::Zero();
  for (std::size_t i = 0; i < bush.size(); ++i) {
    const Spring& spring = leg.bush[i];
    if (spring.turns)
      turned = turned * Eigen::AngleAxisd(bush[i], spring.axis);
    else
      moved += bush[i] * spring.axis;
  }
  Eigen::Isometry3d deflection = Eigen::Isometry3d::Identity();  // deflection of the sole
  deflection.linear() = turned;
  deflection.translation() = ankle + moved - turned * ankle;
  return sole_in_base(robot, side, q) * deflection;
}

Eigen::Isometry3d floor_under_sole(const Leg& leg, const Wrench& lagged) {
  using Eigen::Vector3d;
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  if (!leg.has_pads()) return X_SF;
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
  const Foot& foot = feet_[static_cast<std::size_t>(side)];
  const Leg& leg = robot_.leg(side);
  return measured_sole_in_base(robot_, side, leg_angles(leg, q), foot.bush) *
         floor_under_sole(leg, foot.pads);
}

// The gyro measures the turn of the waist, and the legs measure the motion of each point of contact relative
// to it. The mean of these points, weighted by the loads and horizontally also by how little they slide,
// stays at rest. Heights add up from foot to foot.
std::pair<LegOdometry::Motion, double> LegOdometry::turned(const JointVector& q,
                                                           const SensorReadings& inertial,
                                                           double dt_s) const {
  const Eigen::Isometry3d X_BG_before = imu_in_base(robot_, last_.q), X_BG = imu_in_base(robot_, q);
  const Eigen::Vector3d turn_G = dt_s * inertial.gyro;
  Motion now{X_OB_, Eigen::Vector3d::Zero()};
  now.X_OB.linear() = X_OB_.linear() * X_BG_before.linear() *
                      Eigen::AngleAxisd(turn_G.norm(), turn_G.stableNormalized()).toRotationMatrix() *
                      X_BG.linear().transpose();
  const Eigen::Vector3d changed =
      dt_s * (X_OB_.linear() * X_BG_before.linear() * (last_.accelerometer + inertial.accelerometer) / 2);
  const Eigen::Vector2d predicted =
      (dt_s * (velocity_ + changed) + X_OB_.linear() * X_BG_before.translation() -
       now.X_OB.linear() * X_BG.translation())
          .head<2>();
  const double all =
      (1 - kCarries) * (std::max(0.0, last_.left.force.z()) + std::max(0.0, last_.right.force.z()));
  const bool coasts = dt_s > 0 && coasted_s_ < kCoasting_s;
  const double sliding_m = dt_s * (kSliding_m_s + kLessSure_m_s2 * coasted_s_);
  Eigen::Array3d moved = Eigen::Array3d::Zero(), weights = moved;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  if (coasts) moved.head<2>() = kPredicted * all * predicted, weights.head<2>() = kPredicted * all;
  double at_rest = 0;
  for (const Side side : {Side::right, Side::left}) {
    const Wrench& wrench = side == Side::left ? last_.left : last_.right;
    const double load = wrench.force.z(), carried = load - kCarries / (1 - kCarries) * all;
    if (!(carried > 0)) continue;
    const Leg& leg = robot_.leg(side);
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    point.head<2>() = Eigen::Vector2d(-wrench.torque.y() / load, wrench.torque.x() / load)
                          .cwiseMax(leg.sole_min)
                          .cwiseMin(leg.sole_max);
    const Eigen::Vector3d before = X_OB_.linear() * (feet_[static_cast<std::size_t>(side)].X_BS * point);
    const Eigen::Vector3d after = now.X_OB.linear() * (X_BS(side, q) * point);
    const double slid_m = ((before - after).head<2>() - predicted).norm();
    const double ratio = coasts ? slid_m / sliding_m : 0, still = carried * std::exp(-ratio * ratio);
    const Eigen::Array3d weight(still, still, carried);
    moved += weight * (before - after).array();
    weights += weight;
    place += carried * after;
    at_rest += still;
  }
  const bool any = weights.z() > 0;
  if (any)
    moved /= weights;
  else if (coasts)
    moved.head<2>() = predicted;
  now.X_OB.translation() += moved.matrix();
  if (any) now.p_OS = now.X_OB.translation() + place / weights.z();
  return {now, any ? at_rest / all : 0};
}

void LegOdometry::follow_points(const SensorReadings& readings) {
  if (!started_) {
    X_OB_ = X_OB_start_;
    started_ = true;
  } else {
    const auto [now, at_rest] = turned(readings.q, readings, kPeriod);
    const auto imu = [&](const Eigen::Isometry3d& X_OB, const JointVector& q) -> Eigen::Vector3d {
      return X_OB * imu_in_base(robot_, q).translation();
    };
    velocity_ = (imu(now.X_OB, readings.q) - imu(X_OB_, last_.q)) / kPeriod;
    velocity_.z() = 0;
    coasted_s_ = (coasted_s_ + kPeriod) * (1 - at_rest);
    X_OB_ = now.X_OB;
    if (floor_ == Floor::level) X_OB_.translation().z() -= settling() * now.p_OS.z();
    const Eigen::Vector3d up =
        X_OB_.linear() *
        (imu_in_base(robot_, readings.q).linear() * readings.accelerometer).stableNormalized();
    const Eigen::Vector3d level = kPeriod / kLeveling_s * up.cross(Eigen::Vector3d::UnitZ());
    X_OB_.linear() =
        Eigen::Quaterniond(Eigen::AngleAxisd(level.norm(), level.stableNormalized()) * X_OB_.linear())
            .normalized()
            .toRotationMatrix();
  }
  for (const Side side : {Side::right, Side::left})
    feet_[static_cast<std::size_t>(side)].X_BS = X_BS(side, readings.q);
  last_ = readings;
}

void LegOdometry::add(const SensorReadings& readings) {
  for (const Side side : {Side::right, Side::left}) {
    const Leg& leg = robot_.leg(side);
    const Wrench& wrench = side == Side::left ? readings.left : readings.right;
    const std::vector<double> rest = deflections(leg, wrench);
    Foot& foot = feet_[static_cast<std::size_t>(side)];
    if (!started_) foot = {rest, wrench};
    for (std::size_t i = 0; i < rest.size(); ++i)
      foot.bush[i] += yields(leg.bush[i].lag_s) * (rest[i] - foot.bush[i]);
    foot.pads.force += yields(leg.pad_lag_s) * (wrench.force - foot.pads.force);
    foot.pads.torque += yields(leg.pad_lag_s) * (wrench.torque - foot.pads.torque);
  }
  if (by_points_) return follow_points(readings);
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

void LegOdometry::move_to(const FootPose& waist, const JointVector& q) {
  const Eigen::Isometry3d X = sole(waist) * sole(on_floor(motion(q).X_OB)).inverse();
  X_OB_ = X * X_OB_;
  X_OS_ = X * X_OS_;
  velocity_ = X.linear() * velocity_;
}

LegOdometry::Motion LegOdometry::motion(const JointVector& q, double dt_s) const {
  if (by_points_) return turned(q, last_, dt_s).first;
  return {X_OS_ * X_BS(carrying_, q).inverse(), X_OS_.translation()};
}

}  // namespace walking
