#include "sim/stream/trajectory_file.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "sim/stream/text_line.h"

namespace sim::stream {
namespace {

namespace fs = std::filesystem;
using Unit = TextLine::Unit;

// The lines of a file that are no comments. Texts live as long as this does.
struct Lines {
  explicit Lines(const fs::path& file) {
    std::ifstream input(file);
    if (fs::is_directory(file) || !input) throw FileError(file, "cannot be opened");
    for (std::string text; std::getline(input, text);) texts.push_back(text);
    if (input.bad()) throw FileError(file, "cannot be read");
    for (std::size_t i = 0; i < texts.size(); ++i) {
      const TextLine line(file, i + 1, texts[i]);
      if (!line.is_comment()) lines.push_back(line);
    }
    if (lines.empty()) throw FileError(file, "has no pose in it");
  }
  std::vector<std::string> texts;
  std::vector<TextLine> lines;
};

Eigen::Isometry3d kitti_pose(const TextLine& line) {
  Eigen::Matrix<double, 3, 4> M;
  for (int i = 0; i < 12; ++i) M(i / 4, i % 4) = line.number(static_cast<std::size_t>(i));
  const Eigen::Matrix3d R = M.leftCols<3>();
  if (!(R.transpose() * R).isIdentity(1e-2) || R.determinant() < 0)
    line.fail(0, "the first three columns are no rotation");
  Eigen::Isometry3d X(Eigen::Quaterniond(R).normalized());
  X.translation() = M.col(3);
  return X;
}

Eigen::Isometry3d euroc_pose(const TextLine& line) {
  const Eigen::Quaterniond q(line.number(4), line.number(5), line.number(6), line.number(7));
  if (std::abs(q.norm() - 1) > 1e-2) line.fail(4, "the quaternion is not of length 1");
  Eigen::Isometry3d X(q.normalized());
  X.translation() = Eigen::Vector3d(line.number(1), line.number(2), line.number(3));
  return X;
}

void require_rising(const std::vector<TumRow>& rows, const std::vector<TextLine>& lines) {
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].t <= rows[i - 1].t) lines[i].fail(0, "the stamp is not after the one before");
}

// Beyond 9e9, or more than a day from pose to pose on average: no seconds.
Unit unit_of(const std::vector<TextLine>& lines) {
  const double first = lines.front().number(0), last = lines.back().number(0);
  return last > 9e9 || last - first > 1e5 * static_cast<double>(lines.size()) ? Unit::nanoseconds
                                                                              : Unit::seconds;
}

TrajectoryFile read_tum_like(const std::vector<TextLine>& lines) {
  const std::size_t n = lines.front().size();
  const Unit unit = unit_of(lines);
  TrajectoryFile read{
      n == 20 ? "TUM with covariance" : "TUM", unit == Unit::seconds ? "seconds" : "nanoseconds", {}};
  for (const TextLine& line : lines) {
    if (line.size() != 8 && line.size() != n)
      line.fail(fmt::format("expected {} numbers, found {}", n, line.size()));
    TumRow row;
    row.t = line.stamp(0, unit);
    row.X = tum_pose(line);
    if (line.size() == 20) row.covariance = tum_covariance(line);
    read.rows.push_back(row);
  }
  require_rising(read.rows, lines);
  return read;
}

TrajectoryFile read_euroc(const std::vector<TextLine>& lines) {
  const bool whole = lines.front().text(0).find_first_of(".eE") == std::string_view::npos;
  TrajectoryFile read{"EuRoC csv", whole ? "nanoseconds" : "seconds", {}};
  for (const TextLine& line : lines) {
    if (line.size() < 8) line.fail(fmt::format("expected at least 8 numbers, found {}", line.size()));
    TumRow row;
    row.t = line.stamp(0, whole ? Unit::nanoseconds : Unit::seconds);
    row.X = euroc_pose(line);
    read.rows.push_back(row);
  }
  require_rising(read.rows, lines);
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
  const Lines stamps(times);
  if (stamps.lines.size() != read.rows.size())
    throw FileError(times, fmt::format("has {} times for {} poses", stamps.lines.size(), read.rows.size()));
  for (std::size_t i = 0; i < read.rows.size(); ++i) read.rows[i].t = stamps.lines[i].stamp(0, Unit::seconds);
  require_rising(read.rows, stamps.lines);
  read.stamps = "seconds";
  return read;
}

}  // namespace

TrajectoryFile read_trajectory(const fs::path& file) {
  const Lines all(file);
  const TextLine& first = all.lines.front();
  const std::string& text = all.texts[first.line_number() - 1];
  if (text.find(',') != text.npos) return read_euroc(all.lines);
  if (first.size() == 12) return read_kitti(file, all.lines);
  if (first.size() == 8 || first.size() == 20) return read_tum_like(all.lines);
  first.fail(
      fmt::format("has {} numbers, expected 8 or 20 (TUM), 12 (KITTI), or a csv (EuRoC)", first.size()));
}

}  // namespace sim::stream
