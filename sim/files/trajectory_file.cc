#include "sim/files/trajectory_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using Unit = TextLine::Unit;

Eigen::Isometry3d kitti_pose(const TextLine& line) {
  Eigen::Matrix<double, 3, 4> M;
  for (int i = 0; i < 12; ++i) M(i / 4, i % 4) = line.number(static_cast<std::size_t>(i));
  const Eigen::Matrix3d R = M.leftCols<3>();
  if (!(R.transpose() * R).isIdentity(1e-2) || R.determinant() < 0)
    line.fail(0, "the first three columns are no rotation");
  Eigen::Isometry3d X(Eigen::Quaterniond(R).normalized());
  X.translation() = Eigen::Vector3d(coordinate(line, 3), coordinate(line, 7), coordinate(line, 11));
  return X;
}

// Stamps beyond 9e9, or more than a day from pose to pose on average, are not seconds.
Unit unit_of(const std::vector<TextLine>& lines) {
  const double first = lines.front().number(0), last = lines.back().number(0);
  return last > 9e9 || last - first > 1e5 * static_cast<double>(lines.size()) ? Unit::nanoseconds
                                                                              : Unit::seconds;
}

// Drops a last pose that has the stamp of the one before. Throws FileError where stamps do not rise
// otherwise.
void settle_stamps(TrajectoryFile& read, const std::vector<TextLine>& lines) {
  const std::size_t n = read.rows.size();
  if (n > 2 && read.rows[n - 1].t == read.rows[n - 2].t) {
    read.rows.pop_back();
    read.warning = "its last pose has the stamp of the one before and is left out";
  }
  require_rising_stamps(read.rows, lines);
}

TrajectoryFile read_tum_like(const std::vector<TextLine>& lines) {
  const auto with_covariance = [](const TextLine& line) { return line.size() == 20; };
  const std::size_t n = std::any_of(lines.begin(), lines.end(), with_covariance) ? 20 : 8;
  const Unit unit = unit_of(lines);
  TrajectoryFile read{
      n == 20 ? "TUM with covariance" : "TUM", unit == Unit::seconds ? "seconds" : "nanoseconds", {}};
  for (const TextLine& line : lines) {
    if (line.size() != 8 && line.size() != n)
      line.fail(fmt::format("expected {} numbers, found {}", n, line.size()));
    read.rows.push_back(parse_tum_row(line, unit));
  }
  settle_stamps(read, lines);
  return read;
}

// Whole numbers that rise by less than 1000 from pose to pose are no nanoseconds.
bool are_frame_numbers(const std::vector<TextLine>& lines) {
  return lines.back().number(0) - lines.front().number(0) < 1000 * static_cast<double>(lines.size() - 1);
}

TrajectoryFile read_euroc(const std::vector<TextLine>& lines) {
  const bool numbers = lines.front().text(0).find_first_of(".eE") == std::string_view::npos,
             counted = numbers && are_frame_numbers(lines), whole = numbers && !counted;
  TrajectoryFile read{"EuRoC csv", counted ? "frame numbers" : whole ? "nanoseconds" : "seconds", {}};
  for (const TextLine& line : lines) {
    if (line.size() < 8) line.fail(fmt::format("expected at least 8 numbers, found {}", line.size()));
    TumRow row;
    row.t = line.stamp(0, whole ? Unit::nanoseconds : Unit::seconds);
    row.X = parse_pose(line, 4, 5);
    read.rows.push_back(row);
  }
  settle_stamps(read, lines);
  return read;
}

TrajectoryFile read_kitti(const fs::path& file, const std::vector<TextLine>& lines) {
  TrajectoryFile read{"KITTI", "frame numbers", {}};
  for (const TextLine& line : lines) {
    if (line.size() != 12) line.fail(fmt::format("expected 12 numbers, found {}", line.size()));
    TumRow row;
    row.t = std::chrono::seconds(read.rows.size());
    row.X = kitti_pose(line);
    read.rows.push_back(row);
  }
  const fs::path times = file.parent_path() / "times.txt";
  if (!fs::exists(times)) return read;
  const TextLines text(times);
  const std::vector<TextLine>& stamps = text.lines();
  if (stamps.size() != read.rows.size())
    throw FileError(times, fmt::format("has {} times for {} poses", stamps.size(), read.rows.size()));
  for (std::size_t i = 0; i < stamps.size(); ++i) read.rows[i].t = stamps[i].stamp(0, Unit::seconds);
  settle_stamps(read, stamps);
  read.stamps = "seconds";
  return read;
}

}  // namespace

TrajectoryFile read_trajectory(const fs::path& file) {
  const TextLines text(file);
  const std::vector<TextLine>& lines = text.lines();
  if (lines.empty()) throw FileError(file, "has no pose in it");
  const TextLine& first = lines.front();
  if (first.has_commas()) return read_euroc(lines);
  if (first.size() == 12) return read_kitti(file, lines);
  if (first.size() == 8 || first.size() == 20) return read_tum_like(lines);
  first.fail(
      fmt::format("has {} numbers, expected 8 or 20 (TUM), 12 (KITTI), or a csv (EuRoC)", first.size()));
}

}  // namespace sim::files
