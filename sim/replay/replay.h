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
  /// Why the replayed estimator would have steered the robot on a different walk, if so.
  std::optional<std::string> counterfactual = {};
  std::string models_hash = {};  ///< hash of the simulated walk's models; empty if unknown
};

/// Reads the about.json of a result folder. Throws FileError.
WalkEnd read_walk_end(const fs::path& result_folder);

/// Whether a replay copies the recording into its result.
enum class Recorded { left_out, copied };

/// Replays `recording` and writes a complete result folder: the same bytes as a run of the scenario, except
/// timing.* and, unless copied, recording/. sessions: results of the scenario's sessions; by default, the
/// ones in the folder that contains the recording. Throws FileError if the recording was changed, or if
/// `place` cannot be written.
result::Outcome replay(const scenario::ReadScenario& scenario, const fs::path& recording, const WalkEnd& walk,
                       const result::ResultPlace& place, const result::Progress& progress,
                       Recorded recorded = Recorded::left_out, const std::vector<fs::path>& sessions = {});

/// Returns the scenario for a replay of an external recording, with the noise stated in the folder, no
/// additional sensor errors, and `changes` applied last. Without a walking plan, the initial standard
/// deviation of the gyro's bias is 0.1 rad/s, and accelerometer, plan velocity and height are not used.
scenario::ReadScenario external_scenario(const recording::AslFolder& folder,
                                         const scenario::Changes& changes);

/// Replays a EuRoC/ASL folder from its first image and writes a complete result folder; the truth is moved so
/// that its first pose is the start of the estimate. Throws FileError.
result::Outcome replay_external(const scenario::ReadScenario& scenario, recording::AslFolder& folder,
                                const result::ResultPlace& place, const result::Progress& progress);

/// Which body a trajectory describes.
enum class PosedBody { camera, imu };

/// The output of an external program for the export of a recording.
struct ExternalRun {
  fs::path trajectory;       ///< in any format that files::read_trajectory reads
  std::string columns = {};  ///< names of its columns, if given; see files::read_trajectory
  PosedBody body = PosedBody::camera;
  score::Alignment alignment = score::Alignment::none;  ///< aligns its world with W, by the truth
  std::string log = {};                                 ///< output of the program
  double cpu_ms = 0;                                    ///< CPU time of the whole run
  bool keep = false;                                    ///< keep it in the result as trajectory.txt
  std::optional<std::string> failed = {};               ///< why the trajectory is missing
  /// For sessions: the first one's world in the room, set by the first call and used by the others.
  std::optional<score::Similarity>* in_room = nullptr;
  std::function<void(const std::string&)> warn = [](const std::string&) {};
};

/// Writes all result files except recording/ into a folder, from the poses within 2 ms of frames. Their
/// stamps start at 0 s (as in the run), at 1e9 s (as in its exports) or, in KITTI format, at the first image.
/// An unusable trajectory counts as a failure of the program. Throws FileError as replay() does.
result::Outcome score_external(const scenario::ReadScenario& scenario, const fs::path& recording,
                               const WalkEnd& walk, const ExternalRun& run, const result::ResultPlace& place,
                               const fs::path& into, result::Timing timing);

}  // namespace sim::replay
