// The input of the score, made from the record of a run.
#pragma once

#include <vector>

#include "sim/result/run_record.h"
#include "sim/score/run.h"
#include "walking/plan.h"

namespace sim::result {

/// Returns the landings and the end of a plan.
score::PlannedTimes planned_times(const walking::WalkOptions& walk);

/// Returns X_PC at the frames, from the planned waist and the camera in the planned posture.
std::vector<files::TimedPose> planned_camera(const RunRecord& record);

/// Returns the input of the score. The filter's camera model also projects true points: a test shows that the
/// renderer's lens agrees with it.
score::Run score_input(const RunRecord& record);

/// Returns the commanded path, laid into the world at the start. waist_plan: the planned waist at the frames,
/// with all corrections. The path of a steered walk is the cart-table plan of its commands, at the same
/// stamps.
score::DesiredPath desired_path(const walking::WalkOptions& walk,
                                const std::vector<files::TimedPose>& waist_plan);

}  // namespace sim::result
