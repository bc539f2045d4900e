// Errors of poses and motions with the terms and definitions of the evaluation program evo.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/score/relative.h"

namespace sim::trajectory_score {

/// The part of the difference E of two poses (or of two motions) that is the error. trans_part:
/// |translation|, m · angle_deg, angle_rad: of its rotation · rot_part: |R − I|, full: |E − I|, both
/// Frobenius · point_distance: of poses as trans_part; of motions the difference of the distances between
/// their ends, m.
enum class Relation { trans_part, angle_deg, angle_rad, rot_part, full, point_distance };
/// "m", "deg", "rad" or "1".
std::string unit(Relation relation);

/// Between each true and each estimated pose: E = X_true⁻¹ X_estimate.
std::vector<double> pose_errors(const std::vector<score::PosePair>& pairs, Relation relation);
/// Between true and estimated motion over each span: E of score::relative_difference.
std::vector<double> motion_errors(const std::vector<score::PosePair>& pairs,
                                  const std::vector<score::Span>& over, Relation relation);

/// Statistics of a list of errors, named as evo names them (std: of n, not n − 1).
struct ErrorStatistics {
  std::size_t n = 0;
  double rmse = 0, mean = 0, median = 0, std = 0, min = 0, max = 0, p95 = 0, p99 = 0, sse = 0;
};
/// errors: at least one.
ErrorStatistics describe(const std::vector<double>& errors);

}  // namespace sim::trajectory_score
