// Two trajectory files, read and paired by their stamps.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/trajectory_file.h"
#include "sim/score/trajectory.h"

namespace sim::trajectory_score {

/// interpolate: pair each estimate with the truth interpolated at its stamp, instead of the nearest one at
/// most most_apart_s away. most_gap_s: the longest time between two true poses that interpolation crosses; by
/// default three times their median interval, at least 0.1 s. offset_s: added to the stamps of the estimate.
struct PairingOptions {
  double most_apart_s = 0.01, offset_s = 0;
  bool interpolate = false;
  std::optional<double> most_gap_s = {};
};

/// How much of the truth the pairs cover. Each pair stands for the time until the next, as long as that is
/// not a gap. walked_m: of the truth from the first to the last pair.
struct Coverage {
  std::size_t true_poses = 0;
  double time_fraction = 0, walked_m = 0;
};

struct PairedFiles {
  std::string truth, estimate;  ///< one line each about the file
  std::string pairing;          ///< how poses were paired
  std::vector<score::PosePair> pairs;
  Coverage coverage;
  files::TrajectoryFile estimate_file;
  bool has_orientation = true;  ///< both files have more than positions
};

/// Reads and pairs. need_motion: positions are compared. Throws FileError if a file is not a trajectory, if
/// its stamps are not in the unit of the other's, if it has no stamps and another number of poses than the
/// other, or if its positions do not move; std::invalid_argument if no or hardly any poses have a partner.
PairedFiles pair_files(const std::filesystem::path& truth, const std::filesystem::path& estimate,
                       const PairingOptions& options, bool need_motion);

inline double seconds(score::Stamp t) { return std::chrono::duration<double>(t).count(); }
score::Stamp stamp(double seconds);

}  // namespace sim::trajectory_score
