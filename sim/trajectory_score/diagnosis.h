// The one change of an estimate that would explain most of its error.
#pragma once

#include "sim/score/trajectory.h"

namespace sim::trajectory_score {

/// Two trajectories, their pairs, and how these are aligned.
struct Compared {
  const files::TrajectoryFile& truth;
  const files::TrajectoryFile& estimate;
  const std::vector<score::PosePair>& pairs;
  score::Stamp most_gap, offset;  ///< between two true poses; added to the estimate's stamps
  score::Alignment alignment;     ///< se3 in place of none and origin, sim3 in place of scale
};

/// Returns a sentence on the change that cuts the error of positions (after the alignment) or of
/// orientations most, at least fivefold, and the option that applies it: a clock offset up to 40 s, a
/// constant turn between the two bodies, a mirrored axis, or positions in other units. Nothing if none does.
std::optional<std::string> diagnosis(const Compared& compared);

}  // namespace sim::trajectory_score
