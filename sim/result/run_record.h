// The record of a finished run: its truth, what was tracked, and how it ended.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "sim/tracking/tracking.h"

namespace sim::result {

struct RunRecord {
  const scenario::ReadScenario& scenario;
  scenario::Ended walk;
  recording::RecordingSetup setup;
  recording::Truth truth;
  std::optional<tracking::Tracked> tracked;  ///< absent without slam
  std::string recording_hash;
  std::vector<files::TimedPose> planned_camera = {};  ///< X_PC, where no waist was planned
  std::optional<std::string> counterfactual =
      {};                                     ///< why the replayed filter would have steered another walk
  std::optional<std::string> alignment = {};  ///< by which the truth placed an external trajectory in W
  std::optional<std::string> no_scale = {};   ///< the reason, if the estimate's scale is unknown
};

/// Returns the ending of the walk, or of the estimate on a completed walk.
scenario::Ended ending_of(const RunRecord& record);

}  // namespace sim::result
