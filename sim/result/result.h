// The record of a run, the input of its score, and its result folder, written completely or not at all.
#pragma once

#include <filesystem>

#include "sim/files/atomic_file.h"
#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "sim/score/run.h"
#include "sim/tracking/tracking.h"
#include "slam/observation.h"
#include "walking/plan.h"

namespace sim::result {

/// The CPU time of a frame by stage.
struct FrameTiming {
  slam::Stamp t{0};
  double plan_and_physics_ms = 0, render_ms = 0, encode_ms = 0, record_ms = 0, filter_ms = 0;  ///< CPU time
  int landmarks = 0;     ///< number in the filter's map after the frame
  bool answered = true;  ///< false: the frame was dropped or the estimator had failed
};

/// Adds the CPU time that this thread uses during the object's lifetime to a stage.
class StageClock {
 public:
  explicit StageClock(double& stage_ms) : stage_ms_(stage_ms), begin_ms_(tracking::thread_cpu_ms()) {}
  ~StageClock() { stage_ms_ += tracking::thread_cpu_ms() - begin_ms_; }
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;

 private:
  double& stage_ms_;
  double begin_ms_;
};

/// All timings of a run. The wall clock starts with this object.
class Timing {
 public:
  std::vector<FrameTiming> frames;
  std::vector<double> controller_ms;  ///< wall time of each of the walking controller's answers
  bool each_frame = true;             ///< false: only the sum of filter_ms is known, as for a command

  /// Writes timing.csv (one row per frame) and timing.json: frame_cpu_ms_mean (the estimator's CPU time in
  /// frames with an answer); frame_cpu_ms_median and _p99 if the time of each frame is known; realtime_factor
  /// (simulated seconds per wall second of the whole run); the total of each stage; and, for a walk,
  /// controller_ms_median and _p99. Throws FileError.
  void write(const fs::path& folder, double simulated_s) const;

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

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
      {};  ///< why the replayed estimator would have steered a different walk
  std::optional<score::Alignment> alignment = {};  ///< alignment of an external trajectory with the truth
  double scaled_by = 1;                            ///< scale factor of that alignment
  std::optional<std::string> no_scale = {};        ///< why the estimate's scale is unknown, if so
};

/// Returns the time from a frame's stamp until its image is complete.
inline slam::Stamp exposure(const scenario::Scenario& scenario) {
  return scenario.camera ? slam::Stamp(scenario.camera->lead()) : slam::Stamp(0);
}
/// Returns whether the estimator is the built-in filter (with or without images).
bool uses_filter(const scenario::Scenario& scenario);
/// Returns whether it is the filter with images, which starts to track when it has its first landmark.
bool uses_images(const scenario::Scenario& scenario);

/// Returns the ending of the walk or, if the walk was completed, of the estimate.
scenario::Ended ending_of(const RunRecord& record);

/// Called as simulated time advances, with the fraction completed so far (0 to 1).
using Progress = std::function<void(double)>;

/// The folder of a result, which replaces a marked one, and the versions that the result states.
struct ResultPlace {
  fs::path folder;
  fs::path models;                               ///< for a live run
  std::string version, revision;                 ///< version and revision of the program
  std::map<std::string, std::string> libraries;  ///< name and version
  std::string models_hash{};                     ///< hash of the walk's models; empty: unknown
};

/// The ending of a run and its exit code, see limits.h.
struct Outcome : scenario::Ended {
  int exit_code = 0;
};

/// Makes a session from what the ones before left, and writes its result into a folder.
using MakeSession = std::function<Outcome(const scenario::ReadScenario&, const estimators::Session&,
                                          const ResultPlace&, const fs::path& into, const Progress&)>;

/// Makes the sessions before a scenario's own and then this one, whose result is in the place's folder. The
/// others are below it in session-1, session-2, ... Throws whatever `make` throws, and FileError; then
/// and after an interruption, finished sessions of a live run are kept for the next call.
Outcome make_sessions(const scenario::ReadScenario& read, const ResultPlace& place, const Progress& progress,
                      const MakeSession& make);

/// Scores the run and writes all result files except recording/ into `folder`. Throws FileError.
Outcome write_result(const fs::path& folder, const RunRecord& record, const ResultPlace& place,
                     const Timing& timing, double simulated_s);

/// Writes the files of the estimate, the tracked frames and the map, as described in README.md. Throws
/// FileError.
void write_tracked(const fs::path& folder, const tracking::Tracked& tracked);
/// Writes when each frame was answered. For a dropped frame the fields are empty.
void write_answers(const fs::path& file, const tracking::Tracked& tracked, slam::Stamp exposure);

/// Returns the end of a planned walk.
score::Stamp plan_end(const walking::WalkOptions& walk);

/// Returns X_PC at the frames, from the planned waist and the camera in the planned posture.
std::vector<files::TimedPose> planned_camera(const RunRecord& record);

/// Returns the input of the score. The filter's camera model is also used to project true points; a test
/// shows that the renderer's lens agrees with it.
score::Run score_input(const RunRecord& record);

}  // namespace sim::result
