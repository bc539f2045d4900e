#include "sim/score/trajectory.h"

#include <algorithm>
#include <cmath>

namespace sim::score {
namespace {

Trajectory::const_iterator first_not_before(const Trajectory& trajectory, Stamp t) {
  return std::lower_bound(trajectory.begin(), trajectory.end(), t,
                          [](const TimedPose& pose, Stamp stamp) { return pose.t < stamp; });
}

Trajectory::const_iterator nearest_in_time(const Trajectory& trajectory, Stamp t) {
  const auto after = first_not_before(trajectory, t);
  if (after == trajectory.begin()) return after;
  return after == trajectory.end() || t - (after - 1)->t <= after->t - t ? after - 1 : after;
}

}  // namespace

std::vector<PosePair> pair_by_stamp(const Trajectory& truth, const Trajectory& estimate) {
  return pair_by_nearest(truth, estimate, std::chrono::microseconds(100));
}

std::vector<PosePair> pair_by_nearest(const Trajectory& truth, const Trajectory& estimate, Stamp most,
                                      Stamp offset) {
  Trajectory shifted = estimate;
  for (TimedPose& pose : shifted) pose.t += offset;
  const bool fewer_estimates = shifted.size() <= truth.size();
  const Trajectory &few = fewer_estimates ? shifted : truth, &many = fewer_estimates ? truth : shifted;
  std::vector<PosePair> pairs;
  auto last = many.end();  // the pose of the last pair, which is `last_apart` from its partner
  Stamp last_apart{0};
  for (const TimedPose& pose : few) {
    const auto nearest = nearest_in_time(many, pose.t);
    if (nearest == many.end()) continue;
    const Stamp apart = std::chrono::abs(nearest->t - pose.t);
    if (apart > most || (nearest == last && apart >= last_apart)) continue;
    if (nearest == last) pairs.pop_back();
    const auto &of_truth = fewer_estimates ? *nearest : pose,
               &of_estimate = fewer_estimates ? pose : *nearest;
    pairs.push_back({of_estimate.t, of_truth.X, of_estimate.X});
    last = nearest;
    last_apart = apart;
  }
  return pairs;
}

std::vector<PosePair> pair_by_interpolation(const Trajectory& truth, const Trajectory& estimate,
                                            Stamp most_gap) {
  std::vector<PosePair> pairs;
  for (const TimedPose& pose : estimate) {
    const auto after = first_not_before(truth, pose.t);
    const bool between = after != truth.begin() && after != truth.end() && after->t != pose.t;
    if (between && after->t - (after - 1)->t > most_gap) continue;
    if (const auto X = interpolate(truth, pose.t)) pairs.push_back({pose.t, *X, pose.X});
  }
  return pairs;
}

std::optional<Eigen::Isometry3d> interpolate(const Trajectory& trajectory, Stamp t) {
  const auto after = first_not_before(trajectory, t);
  if (after == trajectory.end()) return std::nullopt;
  if (after->t == t) return after->X;
  if (after == trajectory.begin()) return std::nullopt;
  const auto before = after - 1;
  const double s =
      static_cast<double>((t - before->t).count()) / static_cast<double>((after->t - before->t).count());
  const Eigen::Quaterniond q0(before->X.linear()), q1(after->X.linear());
  Eigen::Isometry3d X(q0.slerp(s, q1).normalized());
  X.translation() = (1 - s) * before->X.translation() + s * after->X.translation();
  return X;
}

double path_length(const Trajectory& trajectory) {
  double length = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    length += (trajectory[i].X.translation() - trajectory[i - 1].X.translation()).norm();
  return length;
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();  // of half the angle
  return sine < 1e-12 ? Eigen::Vector3d(2 * q.vec())
                      : Eigen::Vector3d(2 * std::atan2(sine, q.w()) / sine * q.vec());
}

double yaw(const Eigen::Matrix3d& R) { return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)); }

std::vector<double> position_errors(const std::vector<PosePair>& pairs) {
  std::vector<double> errors;
  for (const PosePair& pair : pairs)
    errors.push_back((pair.X_true.translation() - pair.X_estimate.translation()).norm());
  return errors;
}

std::vector<double> orientation_errors(const std::vector<PosePair>& pairs) {
  std::vector<double> errors;
  for (const PosePair& pair : pairs)
    errors.push_back(rotation_vector(pair.X_estimate.linear().transpose() * pair.X_true.linear()).norm());
  return errors;
}

double yaw_error(const PosePair& pair) {
  return yaw(pair.X_true.linear() * pair.X_estimate.linear().transpose());
}

double height_range(const Trajectory& trajectory) {
  if (trajectory.empty()) return 0;
  const auto lower = [](const TimedPose& a, const TimedPose& b) {
    return a.X.translation().z() < b.X.translation().z();
  };
  const auto [least, greatest] = std::minmax_element(trajectory.begin(), trajectory.end(), lower);
  return greatest->X.translation().z() - least->X.translation().z();
}

Drift drift(const Eigen::Isometry3d& X_WB_true, const Eigen::Isometry3d& X_PB,
            const Eigen::Isometry3d& X_PB_start) {
  const double start = yaw(X_PB_start.linear());
  const Eigen::Vector3d shift = Eigen::AngleAxisd(-start, Eigen::Vector3d::UnitZ()) *
                                Eigen::Vector3d(X_WB_true.translation() - X_PB.translation());
  return {shift.x(), shift.y(), yaw(X_WB_true.linear() * X_PB.linear().transpose())};
}

}  // namespace sim::score
