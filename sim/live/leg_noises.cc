#include "sim/live/leg_noises.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sim::live {
namespace {

constexpr double kLasting_s = 3;          // as slam.height.lasting_s
constexpr double kLeastSpeed_m_s = 0.04;  // relative errors of slower walks, for example turns, are unknown
constexpr double kReading_m = 1e-4;       // as errors.leg_odometry.sigma_m
constexpr double kLeastStart = 0.001;     // of the start
constexpr double kLeastVelocity_m_s = 0.003, kLeastRelative = 0.003;

}  // namespace

double LegNoises::Errors::rms() const { return std::sqrt(std::max(0.0, squares) / std::max(1.0, count)); }

void LegNoises::start(const Eigen::Isometry3d& X_WC_known, const Eigen::Isometry3d& X_WC) {
  const Eigen::Isometry3d error = X_WC_known.inverse() * X_WC;
  const Eigen::AngleAxisd turn(error.linear());
  const Eigen::Vector3d turned = turn.angle() * turn.axis();
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    start_m_[std::size_t(axis)].add(error.translation()[axis]),
        start_rad_[std::size_t(axis)].add(turned[axis]);
}

void LegNoises::add(const Eigen::Isometry3d& X_OC, const Eigen::Isometry3d& X_WC, double dt_s) {
  const auto velocity = [&](const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) -> Eigen::Vector3d {
    return to.linear().transpose() * (to.translation() - from.translation()) / dt_s;
  };
  if (std::exchange(started_, true)) {
    const Eigen::Vector3d by_legs = velocity(X_OC_, X_OC);
    frames_.push_back(
        {by_legs, by_legs - velocity(X_WC_, X_WC), X_OC.translation().z() - X_WC.translation().z(), dt_s});
  }
  X_OC_ = X_OC, X_WC_ = X_WC;
}

// The error model is the filter's (slam/sensors.cc): along camera axes x and z.
void LegNoises::end(double stride_s) {
  Eigen::Vector3d steady = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> steadies;
  Eigen::Vector2d stride = Eigen::Vector2d::Zero();
  double squares = 0;
  const auto across = [](const Eigen::Vector3d& v) { return Eigen::Vector3d(-v.z(), 0, v.x()); };
  const auto along = [](const Eigen::Vector3d& v) { return Eigen::Vector3d(v.x(), 0, v.z()); };
  for (const Frame& f : frames_) {
    steady = f.by_legs + std::exp(-f.dt_s / stride_s) * (steady - f.by_legs);
    steadies.push_back(steady);
    stride += Eigen::Vector2d(along(steady).dot(f.error), across(steady).dot(f.error));
    squares += along(steady).squaredNorm();
  }
  const double least = kLeastSpeed_m_s * kLeastSpeed_m_s * double(frames_.size());
  stride = squares > least ? Eigen::Vector2d(stride / squares) : Eigen::Vector2d::Zero();
  if (squares > least) stride_.add(stride.x()), stride_.add(stride.y());

  for (std::size_t i = 0; i < frames_.size(); ++i)
    frames_[i].error -= stride.x() * along(steadies[i]) + stride.y() * across(steadies[i]);

  // The covariance of the errors of successive frames separates errors that last (sway, positive) from white
  // errors of the position (negative) and white errors of the velocity (none). Errors of the position within
  // a stride are much the same over half a step: they count as white errors with the same mean over it.
  Eigen::Vector3d last = Eigen::Vector3d::Zero(), position = last, steady_position = last, sum = last;
  double height = frames_.empty() ? 0 : frames_[0].height_error_m, count = 0;
  for (const Frame& f : frames_) {
    velocity_m_s_.add(f.error);
    sway_m_s_.squares += f.error.dot(std::exchange(last, f.error)), sway_m_s_.count += 3;
    position += f.dt_s * f.error;
    steady_position = position + std::exp(-f.dt_s / stride_s) * (steady_position - position);
    sum += position - steady_position;
    if (++count * f.dt_s >= stride_s / 4) {
      position_m_.add(Eigen::Vector3d(sum / std::sqrt(count)));
      sum.setZero(), count = 0;
    }
    height = f.height_error_m + std::exp(-f.dt_s / kLasting_s) * (height - f.height_error_m);
    height_m_.add(f.height_error_m - height);
    lasting_m_.add(height);
  }
  frames_.clear();
  started_ = false;
}

void LegNoises::add(const LegNoises& other) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    start_m_[axis].add(other.start_m_[axis]), start_rad_[axis].add(other.start_rad_[axis]);
  for (Errors LegNoises::*const errors :
       {&LegNoises::height_m_, &LegNoises::lasting_m_, &LegNoises::position_m_, &LegNoises::velocity_m_s_,
        &LegNoises::stride_, &LegNoises::sway_m_s_})
    (this->*errors).add(other.*errors);
}

std::string LegNoises::yaml() const {
  const auto start = [](const std::array<Errors, 3>& axes) {  // of the worst axis
    return std::max({kLeastStart, axes[0].rms(), axes[1].rms(), axes[2].rms()});
  };
  Errors white = velocity_m_s_;  // without the two other errors; the one of the position enters twice
  white.squares -= std::max(sway_m_s_.squares, -2 * sway_m_s_.squares);
  return fmt::format(
      "slam:\n"
      "  start: {{sigma_position_m: {:.2g}, sigma_orientation_rad: {:.2g}}}\n"
      "  height: {{sigma_m: {:.2g}, sigma_lasting_m: {:.2g}}}\n"
      "  leg_odometry: {{sigma_position_m: {:.2g}, sigma_m_s: {:.2g}, sigma_stride: {:.2g}, "
      "sigma_sway_m_s: {:.2g}, sigma_sway_scale: 0}}\n",
      start(start_m_), start(start_rad_), std::hypot(kReading_m, height_m_.rms()),
      std::hypot(kReading_m, lasting_m_.rms()), std::hypot(kReading_m, position_m_.rms()),
      std::max(kLeastVelocity_m_s, white.rms()), std::max(kLeastRelative, stride_.rms()),
      std::max(kLeastVelocity_m_s, sway_m_s_.rms()));
}

}  // namespace sim::live
