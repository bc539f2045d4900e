// The input of the score, made from the record of a run.
#pragma once

#include <vector>

#include "sim/result/run_record.h"
#include "sim/score/run.h"

namespace sim::result {

/// When the plan's feet come down and when it ends.
score::PlannedTimes planned_times(const walking::WalkOptions& walk);

/// X_PC at the frames: from the planned waist and the camera's place in the planned posture.
std::vector<files::TimedPose> planned_camera(const RunRecord& record);

/// All that the score needs. The filter's camera model projects true points too: a separate test shows that
/// the renderer's lens agrees with it.
score::Run score_input(const RunRecord& record);

}  // namespace sim::result
