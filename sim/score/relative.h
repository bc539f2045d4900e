// Relative pose error (Sturm et al. 2012): the error of the motion over a span of frames, meters, seconds or
// rotation.
#pragma once

#include <cstddef>
#include <vector>

#include "sim/score/trajectory.h"

namespace sim::score {

/// A kind of spans of motion. Consecutive spans: each starts at the end of the previous one and ends at the
/// first pose at least `delta` away; of meters, the first span starts once delta has been walked. These are
/// evo's numbers for frames, meters, degrees and radians. All spans: one from each pose to the later pose
/// nearest to delta away, if it differs from delta by at most `tolerance` times delta (frames: not at all).
/// Rotation adds up from frame to frame in consecutive spans; all spans of rotation are all pairs of poses
/// that are delta apart.
struct Spans {
  enum class Unit { frames, meters, seconds, radians, degrees } unit = Unit::frames;
  double delta = 1;
  bool all = false;
  double tolerance = 0.1;
  bool along_truth = false;  ///< meters and rotation: of the true path, not of the estimated one
};

/// First and last index of a span.
struct Span {
  std::size_t from = 0, to = 0;
};

/// delta > 0 (frames: a whole number). Empty if the trajectory is too short.
std::vector<Span> spans(const std::vector<PosePair>& pairs, const Spans& which);

/// The difference of the motions over one span, E = (X_true_from⁻¹ X_true_to)⁻¹ (X_estimate_from⁻¹
/// X_estimate_to).
Eigen::Isometry3d relative_difference(const std::vector<PosePair>& pairs, const Span& span);

}  // namespace sim::score
