// Trajectories as text, one pose per line: the TUM format, and its 20-column form with covariance.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/text_line.h"

namespace sim::files {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A pose at a time; the variable that holds it names the frames.
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

/// A line of 8 or 20 numbers. Throws FileError.
TumRow parse_tum_row(const TextLine& line, TextLine::Unit unit);
/// A coordinate of a position, in m. Throws FileError for one beyond 1e9 m, whose squares have no accuracy
/// left.
double coordinate(const TextLine& line, std::size_t field);
/// The pose of a line that has its position in fields 1 to 3 and a quaternion whose real part is in field w
/// and whose vector part begins in field x. The quaternion is made unit. Throws FileError.
Eigen::Isometry3d parse_pose(const TextLine& line, std::size_t w, std::size_t x);
/// Throws FileError at the first of the lines whose row's stamp is not after the one before.
void require_rising_stamps(const std::vector<TumRow>& rows, const std::vector<TextLine>& lines);

/// Reads 8- and 20-column lines; lines beginning with # and blank lines are skipped. Stamps must rise. Throws
/// FileError.
std::vector<TumRow> read_tum(const std::filesystem::path& file);

}  // namespace sim::files
