// The record of a finished run: its truth, what was tracked, and how it ended.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "sim/tracking/tracking.h"

namespace sim::result {

/// How a run ended: one of scenario::kEndings and its cause in words.
struct Ending {
  std::string ending, cause;
};

struct RunRecord {
  const scenario::ReadScenario& scenario;
  std::string ending, cause;  ///< of the walk
  recording::RecordingSetup setup;
  recording::Truth truth;
  std::optional<tracking::Tracked> tracked;  ///< absent without slam
  std::string recording_hash;
  std::vector<files::TimedPose> planned_camera = {};  ///< X_PC, where no waist was planned
  std::string counterfactual = {};  ///< why the replayed filter would have steered another walk; else empty
  std::string alignment = {};  ///< by which the truth placed the estimate in W; empty where none was asked
  std::string no_scale = {};   ///< why the estimate's scale means nothing; empty if it does
};

/// The ending of the walk, or of the filter on a walk that was completed.
Ending ending_of(const RunRecord& record);

}  // namespace sim::result
