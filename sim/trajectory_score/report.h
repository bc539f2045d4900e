// The report of `gaitslam score`: two trajectory files, read, paired by stamps and compared as by evo.
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

/// The part of the difference E of two poses (or of two motions) that is the error. trans_part:
/// |translation|, m · angle_deg, angle_rad: of its rotation · rot_part: |R − I|, full: |E − I|, both
/// Frobenius · point_distance: of poses as trans_part; of motions the difference of the distances between
/// their ends, m. E of poses: X_true⁻¹ X_estimate; of motions: score::relative_difference.
enum class Relation { trans_part, angle_deg, angle_rad, rot_part, full, point_distance };

/// Statistics of a list of errors, named as evo names them (std: of n, not n − 1).
struct ErrorStatistics {
  std::size_t n = 0;
  double rmse = 0, mean = 0, median = 0, std = 0, min = 0, max = 0, p95 = 0, p99 = 0, sse = 0;
};

/// relative: score the motion over these spans instead of poses.
struct Options {
  std::optional<score::Alignment> alignment;  ///< absent: no alignment, and the table shows all
  std::size_t poses_to_align = 0;             ///< the number of first poses to align; 0: all
  Relation relation = Relation::trans_part;
  std::optional<score::Spans> relative;
  PairingOptions pairing;
};

/// One line of the report: the pose errors under an alignment, or the motion errors over a kind of span.
struct Row {
  std::string name, unit;
  score::OrAbsent<ErrorStatistics> statistics;
};

struct Report {
  PairedFiles files;
  score::Similarity similarity;    ///< of the alignment in use
  std::string alignment = "none";  ///< its name
  std::vector<Row> rows;           ///< the requested one first
};

/// The file of truth or estimate in a result folder; `path` itself if it is a file. Throws FileError.
std::filesystem::path trajectory_in(const std::filesystem::path& path, bool truth);

/// Reads, pairs, aligns and scores. Throws FileError if a file is not a trajectory, if its stamps are not in
/// the unit of the other's, if it has no stamps and another number of poses than the other, or if its
/// positions do not move; std::invalid_argument with the reason in one line if no or hardly any poses have a
/// partner, if the alignment is not determined, or if no span is as long as asked for.
Report score_files(const std::filesystem::path& truth, const std::filesystem::path& estimate,
                   const Options& options);

std::string table(const Report& report);  ///< for the terminal
std::string json_text(const Report& report);

}  // namespace sim::trajectory_score
