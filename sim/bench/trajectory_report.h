// An estimated trajectory against a true one from files: paired, aligned, scored; as table, JSON, CSV and
// LaTeX.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/score/trajectory_score.h"
#include "sim/stream/evo_zip.h"
#include "sim/stream/trajectory_file.h"

namespace sim::bench {

/// relative: the motion over these spans is scored instead of poses.
struct TrajectoryOptions {
  std::optional<score::Alignment> alignment;  ///< absent: all are shown, none is used
  std::size_t poses_to_align = 0;             ///< the first so many; 0: all
  score::Relation relation = score::Relation::trans_part;
  std::optional<score::Spans> relative;
  double most_apart_s = 0.01, offset_s = 0;
  bool interpolate = false;
};

/// One line of the report: an alignment's pose errors, or the motion errors over a kind of span.
struct TrajectoryRow {
  std::string name, unit;
  std::optional<score::ErrorStatistics> statistics;
  std::string reason;  ///< of their absence
};

struct TrajectoryReport {
  std::string truth, estimate;  ///< one line each on what was read
  std::size_t matched = 0, poses = 0;
  std::string pairing;              ///< how poses were paired
  double path_m = 0;                ///< of the truth's matched poses
  score::Similarity similarity;     ///< of the alignment in use
  std::string alignment = "none";   ///< its name
  std::vector<TrajectoryRow> rows;  ///< the first one is the one asked for
  std::vector<double> errors;       ///< of that row, with the stamps (s) and metres walked at each
  std::vector<double> stamps, walked;
};

/// "none", "origin", "yaw", "se3", "sim3", "scale"; absent for another word.
std::optional<score::Alignment> alignment_of(const std::string& name);
std::string name_of(score::Alignment alignment);

/// The truth's or the estimate's file of a result folder; a file as it is. Throws FileError.
std::filesystem::path trajectory_in(const std::filesystem::path& path, bool truth);

/// Throws FileError for a file that is no trajectory, std::invalid_argument when nothing can be compared:
/// why, in one line.
TrajectoryReport report_trajectories(const std::filesystem::path& truth,
                                     const std::filesystem::path& estimate, const TrajectoryOptions& options);

std::string trajectory_table(const TrajectoryReport& report);
std::string trajectory_json(const TrajectoryReport& report);
std::string trajectory_csv(const TrajectoryReport& report);
std::string trajectory_latex(const TrajectoryReport& report);
stream::EvoResult evo_result(const TrajectoryReport& report);

}  // namespace sim::bench
