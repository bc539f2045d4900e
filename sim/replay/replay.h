// Runs the estimator on a recording, without physics and rendering, or scores a trajectory that another
// program estimated on it.
#pragma once

#include "sim/files/trajectory_file.h"
#include "sim/recording/asl_folder.h"
#include "sim/result/result.h"
#include "sim/score/trajectory.h"
#include "sim/tracking/tracking.h"

namespace sim::replay {

/// How a recorded walk ended.
struct WalkEnd {
  scenario::Ended ended;
  /// Why the replayed estimator would have steered another walk, if it would.
  std::optional<std::string> counterfactual = {};
  std::string models_hash = {};  ///< of the models of the simulated walk; empty if unknown
};

/// Reads the about.json of a result folder. Throws FileError.
WalkEnd read_walk_end(const std::filesystem::path& result_folder);

/// Selects whether a replay copies the recording into its result.
enum class Recorded { left_out, copied };

/// Replays `recording` and writes a complete result folder: the same bytes as a run of the scenario, except
/// timing.* and, unless copied, recording/. Throws FileError if the recording was changed, or if `place`
/// cannot be written.
result::Outcome replay(const scenario::ReadScenario& scenario, const std::filesystem::path& recording,
                       const WalkEnd& walk, const result::ResultPlace& place,
                       const result::Progress& progress, Recorded recorded = Recorded::left_out,
                       const tracking::TrackingObserver& observer = {});

/// Returns the scenario of a replay of an external recording, with the noise that the folder states, no
/// further sensor errors, and `changes` last. Without a walking plan the initial standard deviation of the
/// gyro's bias is 0.1 rad/s, and accelerometer, plan velocity and height are unused.
scenario::ReadScenario external_scenario(const recording::AslFolder& folder,
                                         const scenario::Changes& changes);

/// Replays a EuRoC/ASL folder from its first image and writes a complete result folder; the truth is moved so
/// that its first pose is the start of the estimate. Throws FileError.
result::Outcome replay_external(const scenario::ReadScenario& scenario, recording::AslFolder& folder,
                                const result::ResultPlace& place, const result::Progress& progress);

/// The body of a trajectory.
enum class PosedBody { camera, imu };

/// Output of an external program on the export of a recording.
struct ExternalRun {
  std::filesystem::path trajectory;  ///< in any format of files::read_trajectory
  PosedBody body = PosedBody::camera;
  score::Alignment alignment = score::Alignment::none;  ///< of its world with W, by the truth
  std::string log = {};                                 ///< what it printed
  double cpu_ms = 0;                                    ///< of the whole run
  bool keep = false;                                    ///< the trajectory as trajectory.txt in the result
  std::optional<std::string> failed = {};               ///< why the trajectory is missing
  std::function<void(const std::string&)> warn = [](const std::string&) {};
};

/// Writes a complete result folder from poses within 2 ms of frames with stamps from 0 s on (as in the
/// run), at 1e9 s (as in its exports) or, in KITTI format, at the first image. An unusable trajectory is a
/// failure of the program; throws FileError as replay().
result::Outcome score_external(const scenario::ReadScenario& scenario, const std::filesystem::path& recording,
                               const WalkEnd& walk, const ExternalRun& run, const result::ResultPlace& place,
                               result::Timing timing);

}  // namespace sim::replay
