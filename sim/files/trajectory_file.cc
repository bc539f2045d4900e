#include "sim/files/trajectory_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using std::chrono::nanoseconds;
using Unit = TextLine::Unit;

constexpr std::int64_t kSecond = 1'000'000'000;

std::string seconds(nanoseconds t) {
  const std::int64_t ns = t.count(), whole = ns / kSecond, rest = std::abs(ns % kSecond);
  return fmt::format("{}{}.{:09}", ns < 0 && whole == 0 ? "-" : "", whole, rest);
}

std::string triangle(const Matrix6d& P, int first) {
  std::string text;
  for (int row = first; row < first + 3; ++row)
    for (int column = row; column < first + 3; ++column) text += fmt::format(" {}", P(row, column));
  return text;
}

std::string tum_pose(nanoseconds t, const Eigen::Isometry3d& X) {
  Eigen::Quaterniond q(X.linear());
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Vector3d p = X.translation();
  return fmt::format("{} {} {} {} {} {} {} {}", seconds(t), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
}

Matrix6d covariance(const TextLine& line) {
  Matrix6d P = Matrix6d::Zero();
  std::size_t field = 8;
  for (const int first : {0, 3})
    for (int row = first; row < first + 3; ++row)
      for (int column = row; column < first + 3; ++column)
        P(row, column) = P(column, row) = line.number(field++);
  return P;
}

double coordinate(const TextLine& line, std::size_t field) {
  constexpr double kMost_m = 1e9;
  const double value = line.number(field);
  if (!(std::abs(value) <= kMost_m)) line.fail(field, "a position of more than 1e9 m");
  return value;
}

Eigen::Isometry3d parse_pose(const TextLine& line, std::size_t w, std::size_t x) {
  const Eigen::Quaterniond q(line.number(w), line.number(x), line.number(x + 1), line.number(x + 2));
  if (std::abs(q.norm() - 1) > 1e-2) line.fail(std::min(w, x), "the quaternion is not of length 1");
  Eigen::Isometry3d X(q.normalized());
  X.translation() = Eigen::Vector3d(coordinate(line, 1), coordinate(line, 2), coordinate(line, 3));
  return X;
}

void require_rising_stamps(const std::vector<TumRow>& rows, const std::vector<TextLine>& lines) {
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].t <= rows[i - 1].t) lines[i].fail(0, "the stamp is not after the one before");
}

TumRow parse_tum_row(const TextLine& line, Unit unit) {
  const std::size_t n = line.size();
  if (n != 8 && n != 20) line.fail(fmt::format("expected 8 or 20 numbers, found {}", n));
  TumRow row;
  row.t = line.stamp(0, unit);
  row.X = parse_pose(line, 7, 4);
  if (n == 20) row.covariance = covariance(line);
  return row;
}

Eigen::Isometry3d kitti_pose(const TextLine& line) {
  Eigen::Matrix<double, 3, 4> M;
  for (int i = 0; i < 12; ++i) M(i / 4, i % 4) = line.number(static_cast<std::size_t>(i));
  const Eigen::Matrix3d R = M.leftCols<3>();
  if (!(R.transpose() * R).isIdentity(1e-2) || R.determinant() < 0)
    line.fail(0, "the first three columns are not a rotation");
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

// Drops a last pose that repeats the stamp before. Throws FileError if stamps do not rise otherwise.
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

// Whole numbers that rise by less than 1000 from pose to pose are not nanoseconds.
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

const char* const kTumCovarianceHeader =
    "# timestamp(s) tx ty tz qx qy qz qw Pr11 Pr12 Pr13 Pr22 Pr23 Pr33 Pt11 Pt12 Pt13 Pt22 Pt23 Pt33\n";

std::string tum_row(nanoseconds t, const Eigen::Isometry3d& X) { return tum_pose(t, X) + "\n"; }

std::string tum_row(nanoseconds t, const Eigen::Isometry3d& X, const Matrix6d& covariance) {
  return tum_pose(t, X) + triangle(covariance, 0) + triangle(covariance, 3) + "\n";
}

std::vector<TumRow> read_tum(const fs::path& file) {
  const TextLines text(file);
  std::vector<TumRow> rows;
  for (const TextLine& line : text.lines()) rows.push_back(parse_tum_row(line, TextLine::Unit::seconds));
  require_rising_stamps(rows, text.lines());
  return rows;
}

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
