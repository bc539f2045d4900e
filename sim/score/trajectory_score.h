// One trajectory scored against another as in the evaluation program evo, with its terms and numbers.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/score/alignment.h"
#include "sim/score/errors.h"
#include "sim/score/relative.h"

namespace sim::score {

/// Which part of the difference E of two poses (or of two motions) is the error. trans_part: |translation|, m
/// · angle_deg, angle_rad: of its rotation · rot_part: |R − I|, full: |E − I|, both Frobenius ·
/// point_distance: of poses as trans_part; of motions by how much the distances between their ends differ, m.
enum class Relation { trans_part, angle_deg, angle_rad, rot_part, full, point_distance };
/// "m", "deg", "rad" or "1".
std::string unit(Relation relation);

/// Between each true and each estimated pose: E = X_true⁻¹ X_estimate.
std::vector<double> pose_errors(const std::vector<PosePair>& pairs, Relation relation);
/// Between true and estimated motion over each span: E of relative_difference.
std::vector<double> motion_errors(const std::vector<PosePair>& pairs, const std::vector<Span>& over,
                                  Relation relation);

/// What maps the first `count` pairs' estimates onto their truth (all: count = 0).
OrAbsent<Similarity> align_first(const std::vector<PosePair>& pairs, Alignment alignment, std::size_t count);

}  // namespace sim::score
