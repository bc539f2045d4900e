// Trajectories as text, one pose per line: TUM, its 20-column form with covariance, KITTI, and tables with
// named columns.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <chrono>

#include "sim/files/text.h"

namespace sim::files {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A pose at a time; the variable names the frames.
struct TimedPose {
  std::chrono::nanoseconds t{0};
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
};

/// A line of a TUM file. The quaternion is normalized. covariance: of the error (orientation, position), as
/// defined by slam::Estimate; the file has no blocks between the two, so they are zero.
struct TumRow : TimedPose {
  std::optional<Matrix6d> covariance;
  std::size_t line = 0;  ///< line number in the file it was read from
};

/// Returns "t tx ty tz qx qy qz qw" and a line feed: t in s with nine decimals (exact to the nanosecond), the
/// position in m, and the quaternion with qw >= 0; other numbers have the fewest digits that round-trip.
std::string tum_row(std::chrono::nanoseconds t, const Eigen::Isometry3d& X);

/// The first line of a file of the 20-column form.
extern const char* const kTumCovarianceHeader;

/// Returns tum_row with the upper triangles of the orientation block (rad²) and then of the position block
/// (m²) of `covariance` (order: orientation, position). Evaluation programs for this form define the
/// orientation's error as −Log(R_CW_true R_CW_estimateᵀ), which equals the project's own Log(R_WC_estimateᵀ
/// R_WC_true), and the position's error in W.
std::string tum_row(std::chrono::nanoseconds t, const Eigen::Isometry3d& X, const Matrix6d& covariance);

/// Reads a TUM file as read_trajectory() does, but accepts a file without poses. Throws FileError.
std::vector<TumRow> read_tum(const fs::path& file);

struct TrajectoryFile {
  std::vector<std::string> columns;  ///< their names with units, for --columns; empty: KITTI
  std::vector<TumRow> rows;
  std::array<std::size_t, 3> position{};    ///< places in `columns`
  bool counts_frames = false;               ///< the stamps are frame numbers, as for KITTI without times
  std::optional<std::string> warning = {};  ///< describes omitted rows, if any, and why
  bool has_orientation = true;              ///< otherwise all rotations are the identity
};

/// Reads a trajectory. `columns` or else a header names the columns (see Table). Without either, the file
/// is TUM, in s (8 numbers separated by spaces, or 20 with covariance), or KITTI (12; stamps from times.txt
/// next to it, or else frame numbers). A last pose that repeats the previous stamp is skipped. Throws
/// FileError, including if other stamps do not increase.
TrajectoryFile read_trajectory(const fs::path& file, const std::string& columns = {});

/// Interpolates the position linearly and the orientation along the shortest turn.
Eigen::Isometry3d interpolate(const TimedPose& a, const TimedPose& b, std::chrono::nanoseconds t);

}  // namespace sim::files
