// The record of a run, the input of its score, and its result folder, written completely or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/atomic_file.h"
#include "sim/recording/recording.h"
#include "sim/result/timing.h"
#include "sim/scenario/scenario.h"
#include "sim/score/run.h"
#include "sim/tracking/tracking.h"
#include "walking/plan.h"

namespace sim::result {

/// The record of a finished run: its truth, the tracking, and its ending.
struct RunRecord {
  const scenario::ReadScenario& scenario;
  scenario::Ended walk;
  recording::RecordingSetup setup;
  recording::Truth truth;
  std::optional<tracking::Tracked> tracked;  ///< absent without slam
  std::string recording_hash;
  std::vector<files::TimedPose> planned_camera = {};  ///< X_PC, without a planned waist
  std::optional<std::string> counterfactual =
      {};  ///< why the replayed estimator would have steered another walk
  std::optional<score::Alignment> alignment = {};  ///< of an external trajectory with the truth
  double scaled_by = 1;                            ///< by that alignment
  std::optional<std::string> no_scale = {};        ///< the reason, if the estimate's scale is unknown
};

/// Returns the time from a frame's stamp until its image is complete.
slam::Stamp exposure(const scenario::Scenario& scenario);
/// Returns whether the estimator is the built-in filter, with or without images.
bool uses_filter(const scenario::Scenario& scenario);
/// Returns whether it is the filter with images, which tracks from its first landmark on.
bool uses_images(const scenario::Scenario& scenario);

/// Returns the ending of the walk, or of the estimate on a completed walk.
scenario::Ended ending_of(const RunRecord& record);

/// Called as simulated time advances, with the completed fraction (0 to 1).
using Progress = std::function<void(double)>;

/// The folder of a result, and the versions that it states.
struct ResultPlace {
  std::filesystem::path folder;
  files::Existing existing = files::Existing::reject;
  std::filesystem::path models;                  ///< for a live run
  std::string version, revision;                 ///< of the program
  std::map<std::string, std::string> libraries;  ///< name and version
  std::string models_hash{};                     ///< of the models of the walk; empty: unknown
};

/// The ending of a run and its exit code, see limits.h.
struct Outcome : scenario::Ended {
  int exit_code = 0;
};

/// Scores the run and writes all files of the result but recording/ into `folder`. Throws FileError.
Outcome write_result(const std::filesystem::path& folder, const RunRecord& record, const ResultPlace& place,
                     const Timing& timing, double simulated_s);

/// Writes the files of the estimate, the tracked frames and the map (README.md describes them). Throws
/// FileError.
void write_tracked(const std::filesystem::path& folder, const tracking::Tracked& tracked);
/// Writes when each frame was answered; the fields of a dropped frame are empty.
void write_answers(const std::filesystem::path& file, const tracking::Tracked& tracked, slam::Stamp exposure);

/// Returns the end of a plan.
score::Stamp plan_end(const walking::WalkOptions& walk);

/// Returns X_PC at the frames, from the planned waist and the camera in the planned posture.
std::vector<files::TimedPose> planned_camera(const RunRecord& record);

/// Returns the input of the score. The filter's camera model also projects true points: a test shows that the
/// renderer's lens agrees with it.
score::Run score_input(const RunRecord& record);

}  // namespace sim::result
