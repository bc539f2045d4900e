// The record of a finished run: its truth, the tracking, and its ending.
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
  std::vector<files::TimedPose> planned_camera = {};  ///< X_PC, without a planned waist
  std::optional<std::string> counterfactual =
      {};                                     ///< why the replayed estimator would have steered another walk
  std::optional<std::string> alignment = {};  ///< of an external trajectory with the truth
  std::optional<std::string> no_scale = {};   ///< the reason, if the estimate's scale is unknown
};

/// Returns whether the estimator is the built-in filter, with or without images.
bool uses_filter(const scenario::Scenario& scenario);
/// Returns whether it is the filter with images, which tracks from its first landmark on.
bool uses_images(const scenario::Scenario& scenario);

/// Returns the ending of the walk, or of the estimate on a completed walk.
scenario::Ended ending_of(const RunRecord& record);

}  // namespace sim::result
