// Relative pose error: how wrong the motion over a span of frames, metres, seconds, turning or footsteps is
// (Sturm et al. 2012).
#pragma once

#include <cstddef>
#include <vector>

#include "sim/score/trajectory.h"

namespace sim::score {

/// The spans compared. Consecutive: one begins where the one before ended. All: one from each pose, to the
/// later pose whose distance from it is nearest to `delta`, if it is off by at most `tolerance` of delta
/// (frames: exactly delta). Consecutive spans end at the first pose at least delta away; of metres, the first
/// span begins where delta has been walked for the first time, as in the evaluation program evo, whose
/// numbers these are for frames, metres, degrees and radians. Turning adds up from frame to frame for
/// consecutive spans; all spans of turning are all pairs of poses whose orientations are `delta` apart.
struct Spans {
  enum class Unit { frames, metres, seconds, radians, degrees, footsteps } unit = Unit::frames;
  double delta = 1;
  bool all = false;
  double tolerance = 0.1;
  bool along_truth = false;        ///< metres, turning: of the true path; else of the estimated one
  std::vector<Stamp> footsteps{};  ///< when feet come down; every delta-th is an end
};

/// First and last index of a span.
struct Span {
  std::size_t from = 0, to = 0;
};

/// delta > 0 (frames, footsteps: a whole number). Empty when the trajectory is too short.
std::vector<Span> spans(const std::vector<PosePair>& pairs, const Spans& which);
/// From one given time to the next (the footsteps of a walk): each time stands for the pose nearest to it.
std::vector<Span> spans_between(const std::vector<PosePair>& pairs, const std::vector<Stamp>& times);

/// Difference of the motions over one span, E = (X_true_from⁻¹ X_true_to)⁻¹ (X_estimate_from⁻¹
/// X_estimate_to).
Eigen::Isometry3d relative_difference(const std::vector<PosePair>& pairs, const Span& span);

/// Its size.
struct RelativeError {
  double translation = 0;  ///< m
  double rotation = 0;     ///< rad
};
std::vector<RelativeError> relative_errors(const std::vector<PosePair>& pairs, const std::vector<Span>& over);

}  // namespace sim::score
