// Trajectories of other programs: the format and the unit of the stamps are detected and reported.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/files/tum.h"

namespace sim::files {

struct TrajectoryFile {
  std::string format;  ///< "TUM", "TUM with covariance", "KITTI", "EuRoC csv"
  std::string stamps;  ///< "seconds", "nanoseconds", "frame numbers"
  std::vector<TumRow> rows;
  std::string warning = {};  ///< what was left out, and why; empty if nothing was
};

/// TUM: 8 numbers a line, or 20 where a pose has a covariance (tum.h), stamps in s, or in ns where they are
/// beyond 9e9 or more than a day apart.
/// KITTI: 12, the upper rows of a matrix; stamps from times.txt beside it, else frame numbers, one a second.
/// EuRoC: t, position, quaternion (w first) and whatever follows, with commas; stamps in ns where they are
/// whole numbers, or frame numbers where these rise by less than 1000 from pose to pose, else in s. Lines
/// beginning with # and blank ones are skipped; stamps must rise, but a last pose
/// with the stamp of the one before, as a program leaves that was lost, is left out with a warning. Throws
/// FileError.
TrajectoryFile read_trajectory(const std::filesystem::path& file);

}  // namespace sim::files
