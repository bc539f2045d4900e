// Errors of an estimated trajectory against the true one, pose by pose.
#pragma once

#include <vector>

#include "sim/score/trajectory.h"

namespace sim::score {

/// |p_true − p_estimate| of each pair, m.
std::vector<double> position_errors(const std::vector<PosePair>& pairs);
/// The angle of R_estimateᵀ R_true of each pair, rad.
std::vector<double> orientation_errors(const std::vector<PosePair>& pairs);
/// The rotation about W's z that brings the estimated orientation nearest to the true one, rad, left
/// positive.
double yaw_error(const PosePair& pair);

/// Statistics of a list of errors, named as evo names them (std: of n, not n − 1).
struct ErrorStatistics {
  std::size_t n = 0;
  double rmse = 0, mean = 0, median = 0, std = 0, min = 0, max = 0, p95 = 0, p99 = 0, sse = 0;
};
/// errors: at least one.
ErrorStatistics describe(const std::vector<double>& errors);

/// Greatest minus least height (z), m; 0 for none.
double height_range(const Trajectory& trajectory);

/// The drift of the robot from its plan in axes of the plan's first pose: x forward, y left (m), yaw (rad).
struct Drift {
  double x = 0, y = 0, yaw = 0;
};
/// True minus planned. X_PB_start gives the axes.
Drift drift(const Eigen::Isometry3d& X_WB_true, const Eigen::Isometry3d& X_PB,
            const Eigen::Isometry3d& X_PB_start);

}  // namespace sim::score
