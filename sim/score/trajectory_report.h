// An estimated trajectory against a true one from files: paired, aligned and scored.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/trajectory_file.h"
#include "sim/score/trajectory_score.h"

namespace sim::score {

/// How two trajectories are compared. relative: score the motion over these spans instead of poses.
struct TrajectoryOptions {
  std::optional<Alignment> alignment;  ///< absent: no alignment, and the table shows all
  std::size_t poses_to_align = 0;      ///< the number of first poses to align; 0: all
  Relation relation = Relation::trans_part;
  std::optional<Spans> relative;
  double most_apart_s = 0.01, offset_s = 0;
  bool interpolate = false;
};

/// One line of the report: an alignment's pose errors, or the motion errors over a kind of span.
struct TrajectoryRow {
  std::string name, unit;
  std::optional<ErrorStatistics> statistics;
  std::string reason;  ///< of their absence
};

struct TrajectoryReport {
  std::string truth, estimate;  ///< one line each on what was read
  std::size_t matched = 0, poses = 0;
  std::string pairing;              ///< how poses were paired
  double path_m = 0;                ///< of the truth's matched poses
  Similarity similarity;            ///< of the alignment in use
  std::string alignment = "none";   ///< its name
  std::vector<TrajectoryRow> rows;  ///< the first one is the one asked for
  std::vector<double> errors;       ///< of that row, with the stamps (s) and metres walked at each
  std::vector<double> stamps, walked;
};

/// "none", "origin", "yaw", "se3", "sim3", "scale"; absent for another word.
std::optional<Alignment> alignment_of(const std::string& name);
std::string name_of(Alignment alignment);

/// The file of the truth or of the estimate in a result folder; `path` itself if it is a file. Throws
/// FileError.
std::filesystem::path trajectory_in(const std::filesystem::path& path, bool truth);

/// Reads, pairs, aligns and scores. Throws FileError for a file that is no trajectory, std::invalid_argument
/// with the reason in one line when nothing can be compared.
TrajectoryReport report_trajectories(const std::filesystem::path& truth,
                                     const std::filesystem::path& estimate, const TrajectoryOptions& options);

}  // namespace sim::score
