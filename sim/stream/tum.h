// Trajectories as text, one pose per line: the TUM format, and its 20-column form with covariance.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/stream/file_error.h"

namespace sim::stream {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A pose at a time; the frames are said by the variable that holds it.
struct TimedPose {
  std::chrono::nanoseconds t{0};
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
};

/// A line of a TUM file. The quaternion is made unit on reading. covariance: of the error (orientation,
/// position) as slam::Estimate defines it, the blocks between the two zero (the file does not hold them).
struct TumRow : TimedPose {
  std::optional<Matrix6d> covariance;
};

/// "t tx ty tz qx qy qz qw" and a line feed: t in s with nine decimals (exact to the nanosecond), position in
/// m, the quaternion with qw >= 0; all other numbers with the digits that bring the same bits back. No
/// trailing blank.
std::string tum_row(std::chrono::nanoseconds t, const Eigen::Isometry3d& X);

/// The first line of a file of the 20-column form.
extern const char* const kTumCovarianceHeader;

/// tum_row with the upper triangles of the orientation block (rad²), then of the position block (m²), of
/// `covariance` (order orientation, position). The evaluation programs that read this form take the
/// orientation's error as −Log(R_CW_true R_CW_estimateᵀ), which is Log(R_WC_estimateᵀ R_WC_true), the
/// project's own, and the position's in W.
std::string tum_row(std::chrono::nanoseconds t, const Eigen::Isometry3d& X, const Matrix6d& covariance);

class TextLine;
/// The pose of a line "t tx ty tz qx qy qz qw ..."; the quaternion is made unit.
Eigen::Isometry3d tum_pose(const TextLine& line);
/// The covariance of a line of the 20-column form.
Matrix6d tum_covariance(const TextLine& line);

/// Reads 8- and 20-column lines; lines beginning with # and blank lines are skipped. Stamps must rise. Throws
/// FileError.
std::vector<TumRow> read_tum(const std::filesystem::path& file);

}  // namespace sim::stream
