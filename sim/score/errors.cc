#include "sim/score/errors.h"

#include <algorithm>

#include "sim/score/statistics.h"

namespace sim::score {

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

ErrorStatistics describe(const std::vector<double>& errors) {
  const double m = mean(errors), rmse = root_mean_square(errors);
  std::vector<double> deviations;
  for (const double error : errors) deviations.push_back(error - m);
  return {errors.size(),
          rmse,
          m,
          median(errors),
          root_mean_square(deviations),
          quantile(errors, 0),
          quantile(errors, 1),
          quantile(errors, 0.95),
          quantile(errors, 0.99),
          rmse * rmse * static_cast<double>(errors.size())};
}

double height_range(const Trajectory& trajectory) {
  if (trajectory.empty()) return 0;
  const auto lower = [](const StampedPose& a, const StampedPose& b) {
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
