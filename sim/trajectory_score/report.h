// The report of `gaitslam score`: two trajectory files are read, paired by stamps and compared as in evo.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "sim/score/trajectory.h"

namespace sim::trajectory_score {

/// interpolate: pairs each estimate with the truth interpolated at its stamp, instead of the closest true
/// pose at most most_apart_s away. most_gap_s: the longest time between two true poses that interpolation
/// bridges; by default three times their median interval, at least 0.1 s. offset_s: added to the estimate's
/// stamps.
struct PairingOptions {
  double most_apart_s = 0.01, offset_s = 0;
  bool interpolate = false;
  std::optional<double> most_gap_s = {};
};

/// The part of the difference E of two poses (or of two motions) that counts as the error. trans_part:
/// |translation|, m · angle_deg, angle_rad: angle of its rotation · rot_part: |R − I|, full: |E − I|, both
/// Frobenius norms · point_distance: for poses as trans_part; for motions the difference of the distances
/// between their ends, m. E is X_true⁻¹ X_estimate for poses and score::relative_difference for motions.
enum class Relation { trans_part, angle_deg, angle_rad, rot_part, full, point_distance };

/// relative: score the motion over these spans instead of poses.
struct Options {
  std::optional<score::Alignment> alignment;  ///< absent: no alignment; the table shows all
  std::size_t poses_to_align = 0;             ///< number of poses at the start to align; 0: all
  Relation relation = Relation::trans_part;
  std::optional<score::Spans> relative;
  PairingOptions pairing;
  std::string truth_columns, columns;  ///< column names of the two files, see files::read_trajectory()
  /// The estimate's body in the truth's: a rotation vector to be removed, rad.
  Eigen::Vector3d body_turn = Eigen::Vector3d::Zero();
};

/// Returns the file with the truth or the estimate in a result folder, or `path` itself if it is a file.
/// Throws FileError.
fs::path trajectory_in(const fs::path& path, bool truth);

/// Returns the report on two files, paired and aligned, as described in
/// sim/result/schemas/trajectory.schema.json. The requested errors come first; statistics are named as in evo
/// (std: of n, not n − 1). Throws FileError if a file is not a trajectory, if its stamps are frame numbers
/// and the other file's are not, or if its positions do not move. Throws std::invalid_argument with a
/// one-line reason if too few poses have a partner, if the alignment is not determined, or if no span is as
/// long as requested.
nlohmann::ordered_json score_files(const fs::path& truth, const fs::path& estimate, const Options& options);

/// Returns the report as text for the terminal.
std::string table(const nlohmann::ordered_json& report);

}  // namespace sim::trajectory_score
