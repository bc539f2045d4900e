// The report of `gaitslam score`: two trajectory files, read, paired by stamps and compared as by evo.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

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

/// The part of the difference E of two poses (or of two motions) that is the error. trans_part:
/// |translation|, m · angle_deg, angle_rad: of its rotation · rot_part: |R − I|, full: |E − I|, both
/// Frobenius · point_distance: of poses as trans_part; of motions the difference of the distances between
/// their ends, m. E of poses: X_true⁻¹ X_estimate; of motions: score::relative_difference.
enum class Relation { trans_part, angle_deg, angle_rad, rot_part, full, point_distance };

/// relative: score the motion over these spans instead of poses.
struct Options {
  std::optional<score::Alignment> alignment;  ///< absent: no alignment, and the table shows all
  std::size_t poses_to_align = 0;             ///< the number of first poses to align; 0: all
  Relation relation = Relation::trans_part;
  std::optional<score::Spans> relative;
  PairingOptions pairing;
};

/// Returns the file of truth or estimate in a result folder; `path` itself if it is a file. Throws FileError.
fs::path trajectory_in(const fs::path& path, bool truth);

/// Returns the report on two files, paired and aligned, as sim/result/schemas/trajectory.schema.json
/// describes it: the requested errors first, their statistics named as in evo (std: of n, not n − 1). Throws
/// FileError if a file is not a trajectory, if its stamps are not in the unit of the other's, if it has no
/// stamps and another number of poses than the other, or if its positions do not move; std::invalid_argument
/// with the reason in one line if too few poses have a partner, if the alignment is not determined, or if no
/// span is as long as requested.
nlohmann::ordered_json score_files(const fs::path& truth, const fs::path& estimate, const Options& options);

/// Returns the report for the terminal.
std::string table(const nlohmann::ordered_json& report);

}  // namespace sim::trajectory_score
