#include "sim/live/inertial_check.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "sim/score/trajectory.h"
#include "walking/plan.h"

namespace sim::live {
namespace {

using namespace std::chrono_literals;

constexpr slam::Stamp kBegin = 10s, kLast = 30s;
constexpr double kBlow_m_s2 = 50;  // walking reaches 17
const Eigen::Vector3d kGravity_W(0, 0, -walking::kGravity);

Eigen::Matrix3d turn(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, rotation_vector / angle).toRotationMatrix();
}

void integrate(recording::TrueMotion& at, const Eigen::Vector3d& gyro, const Eigen::Vector3d& force,
               double dt) {
  const Eigen::Matrix3d R = at.X_WG.linear(), R_end = R * turn(gyro * dt);
  const Eigen::Vector3d a_W = (R * force + R_end * force) / 2 + kGravity_W, v = at.v_WG;
  at.v_WG += dt * a_W;
  at.X_WG.translation() += dt / 2 * (v + at.v_WG);
  at.X_WG.linear() = R_end;
}

}  // namespace

InertialCheck::InertialCheck(const recording::TrueMotion& start) { integrations_.push_back(start); }

void InertialCheck::add(const slam::InertialSample& gyro, const slam::InertialSample& accelerometer,
                        const recording::TrueMotion& end) {
  if (accelerometer.value.norm() > kBlow_m_s2) return integrations_.assign(1, end);
  for (recording::TrueMotion& at : integrations_) {
    integrate(at, gyro.value, accelerometer.value, slam::seconds(gyro.end - gyro.begin));
    compare(at, end);
  }
  if (end.t - integrations_.back().t >= kBegin) integrations_.push_back(end);
  if (end.t - integrations_.front().t >= kLast) integrations_.pop_front();
}

void InertialCheck::compare(const recording::TrueMotion& integrated, const recording::TrueMotion& truth) {
  const Eigen::Isometry3d &X = integrated.X_WG, &X_true = truth.X_WG;
  longest_ = std::max(longest_, truth.t - integrated.t);
  worst_position_m_ = std::max(worst_position_m_, (X.translation() - X_true.translation()).norm());
  worst_yaw_rad_ = std::max(worst_yaw_rad_, std::abs(score::yaw(X.linear() * X_true.linear().transpose())));
}

}  // namespace sim::live
