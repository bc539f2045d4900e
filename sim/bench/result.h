// The result folder of a run or a replay: trajectories, map, frames, score; complete or not there at all.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "sim/bench/scenario.h"
#include "sim/bench/timing.h"
#include "sim/bench/tracking.h"
#include "sim/score/evaluate.h"
#include "sim/stream/durable_file.h"
#include "sim/stream/recording.h"

namespace sim::bench {

/// Called as simulated time goes on, with the part done (0 to 1).
using Progress = std::function<void(double)>;

/// Where a result goes and what is said of its making.
struct ResultPlace {
  std::filesystem::path folder;
  stream::Existing existing = stream::Existing::refuse;
  std::filesystem::path models;                  ///< for a live run
  std::string version, revision;                 ///< of the program
  std::map<std::string, std::string> libraries;  ///< name and version
};

/// How a run ended: one of kEndings, its cause in words, and the exit code that follows (0 passed, 1 missed a
/// limit, 3 ended in a way that the scenario does not allow).
struct Outcome {
  std::string ending, cause;
  int exit_code = 0;
};

/// What is left of a run when all is done: written and scored.
struct Remains {
  const ReadScenario& scenario;
  std::string ending, cause;  ///< of the walk
  stream::RecordingSetup setup;
  stream::Truth truth;
  std::optional<Tracked> tracked;  ///< absent without slam
  std::string recording_hash;
  std::vector<stream::TimedPose> planned_camera = {};  ///< X_PC, where no waist was planned
  std::string no_scale = {};  ///< why the estimate's scale is its own; empty if it is not
};

/// Of the walk, or of the filter on a walk that was completed; the exit code is left at 0.
Outcome ending_of(const Remains& remains);

/// Scores the remains and writes all files of the result but recording/ into `folder`.
Outcome write_result(const std::filesystem::path& folder, const Remains& remains, const ResultPlace& place,
                     const Timing& timing, double simulated_s);

/// The table that a result folder's score.json makes on the terminal.
std::string score_table(const std::filesystem::path& result_folder);

}  // namespace sim::bench
