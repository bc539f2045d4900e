#include "sim/live/steering_pose_buffer.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace sim::live {
namespace {

/// Returns the angle of the rotation about z that is closest to R.
double heading(const Eigen::Matrix3d& R) { return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)); }

/// Returns the covariance of the sole's place (axes W) and heading. An error of the camera's attitude,
/// Log(R_estimateᵀ R_true) in axes C, moves the sole by R_WC (error x p_CF).
Eigen::Matrix3d covariance_of_sole(const slam::Estimate& estimate, const Eigen::Vector3d& p_CF) {
  const Eigen::Matrix3d& R_WC = estimate.X_WC.linear();
  const Eigen::Vector3d p_CF_W = R_WC * p_CF;
  Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d turn = R_WC.col(axis);  // in W, for an error about this axis of C
    J.col(axis) << turn.cross(p_CF_W).head<2>(), turn.z();
  }
  J(0, 3) = J(1, 4) = 1;
  return J * estimate.covariance * J.transpose();
}

}  // namespace

walking::PlaceEstimate place_estimate(const slam::Estimate& estimate, const slam::PlannedMotion& planned) {
  const double turned = heading(estimate.X_WC.linear() * planned.X_PC.linear().transpose());
  return {std::chrono::duration<double>(estimate.t).count(),
          {(planned.X_PC * planned.p_CF).head<2>(), 0},
          {(estimate.X_WC * planned.p_CF).head<2>(), turned},
          covariance_of_sole(estimate, planned.p_CF)};
}

SteeringPoseBuffer::SteeringPoseBuffer(const walking::SteeringOptions& options,
                                       const std::vector<sensor_errors::Fault>& faults, slam::Stamp exposure)
    : delay_(std::max(exposure, slam::Stamp(std::llround(1e9 * options.latency_s)))),
      jumps_(sensor_errors::faults_of<sensor_errors::EstimateJump>(faults)),
      frozen_(sensor_errors::faults_of<sensor_errors::EstimateFrozen>(faults)),
      lost_(sensor_errors::faults_of<sensor_errors::EstimateLost>(faults)) {}

void SteeringPoseBuffer::add(slam::Stamp frame, slam::Estimate estimate, bool tracks) {
  const auto holds = [frame](const auto& fault) { return fault.holds(frame); };
  if (!tracks || std::any_of(lost_.begin(), lost_.end(), holds)) return;
  if (std::any_of(frozen_.begin(), frozen_.end(), holds) && last_unfrozen_)
    estimate.X_WC = last_unfrozen_->X_WC;
  else
    last_unfrozen_ = estimate;
  for (const sensor_errors::EstimateJump& jump : jumps_) {
    if (!jump.holds(frame)) continue;
    estimate.X_WC.linear() =
        Eigen::AngleAxisd(jump.yaw_rad, Eigen::Vector3d::UnitZ()) * estimate.X_WC.linear();
    estimate.X_WC.translation() += Eigen::Vector3d(jump.x_m, jump.y_m, 0);
  }
  while (!planned_.empty() && planned_.front().t < estimate.t) planned_.pop_front();
  if (planned_.empty() || planned_.front().t != estimate.t) return;
  places_.push_back({frame, place_estimate(estimate, planned_.front().motion)});
}

std::optional<walking::PlaceEstimate> SteeringPoseBuffer::newest(slam::Stamp until) {
  for (; !places_.empty() && places_.front().frame <= until; places_.pop_front())
    newest_ = places_.front().estimate;
  return newest_;
}

}  // namespace sim::live
