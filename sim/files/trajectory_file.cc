#include "sim/files/trajectory_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using std::chrono::nanoseconds;

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

double coordinate(const TextLine& line, const Column& column) {
  constexpr double kMost_m = 1e9;
  const double value = column.factor * line.number(column.field);
  if (!(std::abs(value) <= kMost_m)) line.fail(column.field, "a position of more than 1e9 m");
  return value;
}

// Indices of the pose's columns.
struct PoseColumns {
  std::size_t stamp = 0;
  std::vector<Column> position{{1}, {2}, {3}}, orientation{{7}, {4}, {5}, {6}};  // w, x, y, z; may be empty

  /// The number of fields that a line needs.
  std::size_t least() const {
    std::size_t last = stamp;
    for (const auto* columns : {&position, &orientation})
      for (const Column& column : *columns) last = std::max(last, column.field);
    return last + 1;
  }
};

Eigen::Isometry3d parse_pose(const TextLine& line, const PoseColumns& columns) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  if (const auto& c = columns.orientation; !c.empty()) {
    const Eigen::Quaterniond q(line.number(c[0].field), line.number(c[1].field), line.number(c[2].field),
                               line.number(c[3].field));
    if (std::abs(q.norm() - 1) > 1e-2)
      line.fail(std::min(c[0].field, c[1].field), "the quaternion is not of length 1");
    X.linear() = q.normalized().toRotationMatrix();
  }
  const auto& p = columns.position;
  X.translation() = Eigen::Vector3d(coordinate(line, p[0]), coordinate(line, p[1]), coordinate(line, p[2]));
  return X;
}

void require_rising_stamps(const std::vector<TumRow>& rows, const std::vector<TextLine>& lines) {
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].t <= rows[i - 1].t) lines[i].fail(0, "the stamp is not after the one before");
}

Eigen::Isometry3d kitti_pose(const TextLine& line) {
  Eigen::Matrix<double, 3, 4> M;
  for (int i = 0; i < 12; ++i) M(i / 4, i % 4) = line.number(static_cast<std::size_t>(i));
  const Eigen::Matrix3d R = M.leftCols<3>();
  if (!(R.transpose() * R).isIdentity(1e-2) || R.determinant() < 0)
    line.fail(0, "the first three columns are not a rotation");
  Eigen::Isometry3d X(Eigen::Quaterniond(R).normalized());
  X.translation() = Eigen::Vector3d(coordinate(line, {3}), coordinate(line, {7}), coordinate(line, {11}));
  return X;
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

// Columns of poses with commas (EuRoC) or without (TUM), as the header names them or in the format's order.
PoseColumns columns_of(const TextLines& text) {
  const std::size_t n = text.lines().front().size();
  const bool commas = text.lines().front().has_commas();
  const auto& header = text.header();
  PoseColumns columns;
  if (commas) columns.orientation = {{4}, {5}, {6}, {7}};
  const bool names_all = header && (header->names(Quantity::orientation) || n == 20);
  if (n < 8 || (header && header->names(Quantity::position))) {
    if (!names_all) columns.orientation.clear();
  }
  if (!header) return columns;
  columns.stamp = header->time_field();
  columns.position = header->columns(Quantity::position, "xyz", 1);
  auto& c = columns.orientation;
  if (c.empty()) return columns;
  c = header->columns(Quantity::orientation, commas ? "wxyz" : "xyzw", 4);
  if (!commas) std::rotate(c.begin(), c.end() - 1, c.end());
  return columns;
}

// Throws FileError if the stamps are not in the unit that the header states.
const TimeUnit& unit_of(const fs::path& file, const std::vector<TextLine>& lines, std::size_t field,
                        const TimeUnit* stated) {
  std::vector<double> stamps;
  for (const TextLine& line : lines) stamps.push_back(line.number(field));
  try {
    return unit_of_stamps(stamps, stated);
  } catch (const std::invalid_argument& contradiction) {
    throw FileError(file, contradiction.what());
  }
}

// Whole numbers that rise by less than 1000 from pose to pose, and are neither dates nor of a stated unit.
bool are_frame_numbers(const std::vector<TextLine>& lines, std::size_t field, const TimeUnit* stated) {
  const double first = lines.front().number(field), last = lines.back().number(field);
  const auto is_whole = [&](const TextLine& line) {
    return line.text(field).find_first_of(".eE") == std::string_view::npos;
  };
  return !stated && last < 1e9 && last - first < 1000 * static_cast<double>(lines.size() - 1) &&
         std::all_of(lines.begin(), lines.end(), is_whole);
}

void require_length(const TextLine& line, const TextLine& first, std::size_t least, bool with_covariance) {
  const std::size_t n = line.size();
  if (n < least && first.has_commas())
    line.fail(fmt::format("expected at least {} numbers, found {}", least, n));
  if (first.has_commas() || n == first.size() || (with_covariance && (n == 8 || n == 20))) return;
  line.fail(fmt::format("expected {} numbers, found {}", with_covariance ? 20 : first.size(), n));
}

TrajectoryFile read_poses(const fs::path& file, const TextLines& text) {
  const std::vector<TextLine>& lines = text.lines();
  const bool commas = lines.front().has_commas();
  const bool with_covariance = !commas && std::any_of(lines.begin(), lines.end(),
                                                      [](const TextLine& line) { return line.size() == 20; });
  const PoseColumns columns = columns_of(text);
  const TimeUnit* const stated = text.header() ? text.header()->time_unit() : nullptr;
  for (const TextLine& line : lines) require_length(line, lines.front(), columns.least(), with_covariance);
  const bool counted = commas && are_frame_numbers(lines, columns.stamp, stated);
  const TimeUnit& unit = counted ? kSeconds : unit_of(file, lines, columns.stamp, stated);
  TrajectoryFile read{commas            ? "EuRoC csv"
                      : with_covariance ? "TUM with covariance"
                                        : "TUM",
                      counted ? "frame numbers" : unit.name,
                      {}};
  read.has_orientation = !columns.orientation.empty();
  for (const TextLine& line : lines) {
    TumRow row;
    row.t = line.stamp(columns.stamp, unit);
    row.X = parse_pose(line, columns);
    if (with_covariance && line.size() == 20) row.covariance = covariance(line);
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
  const TimeUnit& unit = unit_of(times, stamps, 0, nullptr);
  for (std::size_t i = 0; i < stamps.size(); ++i) read.rows[i].t = stamps[i].stamp(0, unit);
  settle_stamps(read, stamps);
  read.stamps = unit.name;
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
  for (const TextLine& line : text.lines()) {
    const std::size_t n = line.size();
    if (n != 8 && n != 20) line.fail(fmt::format("expected 8 or 20 numbers, found {}", n));
    TumRow& row = rows.emplace_back();
    row.t = line.stamp(0, kSeconds);
    row.X = parse_pose(line, {});
    if (n == 20) row.covariance = covariance(line);
  }
  require_rising_stamps(rows, text.lines());
  return rows;
}

TrajectoryFile read_trajectory(const fs::path& file) {
  const TextLines text(file);
  if (text.lines().empty()) throw FileError(file, "has no pose in it");
  const TextLine& first = text.lines().front();
  const std::size_t n = first.size();
  if (n == 12 && !first.has_commas()) return read_kitti(file, text.lines());
  const bool named = text.header() && text.header()->names(Quantity::position);
  if (n == 8 || n == 20 || named || n == 4 || first.has_commas()) {
    if (first.has_commas() && n < 8 && !named)
      first.fail(fmt::format("expected at least 8 numbers, found {}", n));
    return read_poses(file, text);
  }
  first.fail(fmt::format("has {} numbers, expected 8 or 20 (TUM), 12 (KITTI), or a csv (EuRoC)", n));
}

}  // namespace sim::files
