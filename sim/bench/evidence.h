// From what a run left behind to what is scored: truth, plan and estimate side by side.
#pragma once

#include <vector>

#include "sim/bench/result.h"
#include "sim/score/evaluate.h"

namespace sim::bench {

/// A recorded surface as the score sees it.
score::Surface surface(const stream::RecordedSurface& recorded);

/// When the plan's feet come down and when it ends.
score::PlannedTimes planned_times(const walking::WalkOptions& walk);

/// X_PC at the frames: the planned waist with the camera where the planned posture has it.
std::vector<stream::TimedPose> planned_camera(const Remains& remains);

/// All that the score needs. The filter's camera model serves as lens of the truth: that the renderer's own
/// lens agrees with it is a test of its own.
score::Run evidence(const Remains& remains);

}  // namespace sim::bench
