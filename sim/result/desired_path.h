// The path that the commands of a walk describe, laid into the world at the start.
#pragma once

#include <vector>

#include "sim/files/trajectory_file.h"
#include "sim/score/run.h"
#include "walking/plan.h"

namespace sim::result {

/// waist_plan: the planned waist at the frames, with all corrections. The path of a walk that is not steered
/// is its plan; that of a steered one the cart-table's plan of its commands, at the same stamps, and after
/// its end the end.
score::DesiredPath desired_path(const walking::WalkOptions& walk,
                                const std::vector<files::TimedPose>& waist_plan);

}  // namespace sim::result
