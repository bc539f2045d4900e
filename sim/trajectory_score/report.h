// The report of `gaitslam score`: an estimated trajectory against a true one from files, in the terms of evo.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/score/alignment.h"
#include "sim/score/relative.h"
#include "sim/trajectory_score/pairing.h"

namespace sim::trajectory_score {

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
  std::string truth, estimate;  ///< one line each about the file
  std::size_t matched = 0, poses = 0;
  std::string pairing;             ///< how poses were paired
  Coverage coverage;               ///< of the truth
  score::Similarity similarity;    ///< of the alignment in use
  std::string alignment = "none";  ///< its name
  std::vector<Row> rows;           ///< the requested one first
};

/// The file of the truth or of the estimate in a result folder; `path` itself if it is a file. Throws
/// FileError.
std::filesystem::path trajectory_in(const std::filesystem::path& path, bool truth);

/// Reads, pairs, aligns and scores. Throws as pair_files(), and std::invalid_argument with the reason in one
/// line if the alignment is not determined or no span is as long as asked for.
Report score_files(const std::filesystem::path& truth, const std::filesystem::path& estimate,
                   const Options& options);

std::string table(const Report& report);  ///< for the terminal
std::string json_text(const Report& report);

}  // namespace sim::trajectory_score
