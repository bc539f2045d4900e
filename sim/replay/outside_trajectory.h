// Scores a trajectory that another program estimated on the export of a recording, as if the program had run
// in the loop.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "sim/files/trajectory_file.h"
#include "sim/replay/replay.h"
#include "sim/score/alignment.h"

namespace sim::replay {

/// What the poses of a trajectory are of.
enum class PosedBody { camera, imu };

/// What another program left. A trajectory that cannot be used is its failure.
struct OutsideRun {
  std::filesystem::path trajectory;  ///< in any format of files::read_trajectory
  PosedBody body = PosedBody::camera;
  score::Alignment alignment = score::Alignment::none;  ///< of its world with W, by the truth
  std::string log = {};                                 ///< what it printed
  double cpu_ms = 0;                                    ///< of the whole run
  std::optional<std::string> failed = {};               ///< why it left no trajectory
};

/// Writes a complete result folder. Stamps may be those of the run (from 0), of its exports (from 1e9 s) or,
/// where the file's format is KITTI, from the first image; a pose belongs to the frame whose stamp is within
/// 2 ms. Truth is opened once the program is done. timing: begun before the program. Throws FileError as
/// replay() does.
result::Outcome score_outside(const scenario::ReadScenario& scenario, const std::filesystem::path& recording,
                              const WalkEnd& walk, const OutsideRun& run, const result::ResultPlace& place,
                              result::Timing timing);

}  // namespace sim::replay
