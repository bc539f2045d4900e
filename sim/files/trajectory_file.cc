#include "sim/files/trajectory_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "sim/files/table.h"

namespace sim::files {
namespace {

using std::chrono::nanoseconds;

std::string seconds(nanoseconds t) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t ns = t.count(), whole = ns / kSecond, rest = std::abs(ns % kSecond);
  return fmt::format("{}{}.{:09}", ns < 0 && whole == 0 ? "-" : "", whole, rest);
}

std::string tum_pose(nanoseconds t, const Eigen::Isometry3d& X) {
  Eigen::Quaterniond q(X.linear());
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Vector3d p = X.translation();
  return fmt::format("{} {} {} {} {} {} {} {}", seconds(t), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
}

// Calls `each` with row and column for the upper triangle of the orientation's block, then of the position's.
void for_each_covariance(const auto& each) {
  for (const int first : {0, 3})
    for (int row = first; row < first + 3; ++row)
      for (int column = row; column < first + 3; ++column) each(row, column);
}

constexpr const char* kTum = "t[s] tx ty tz qx qy qz qw";
constexpr const char* kTumCovariance =
    "t[s] tx ty tz qx qy qz qw Pr11 Pr12 Pr13 Pr22 Pr23 Pr33 Pt11 Pt12 Pt13 Pt22 Pt23 Pt33";

std::string expected_poses(const Table& table) {
  const std::vector<std::string> names = table.names();
  const bool named = names.size() == table.width() && std::ranges::count(names, "-") + 4 <= std::ssize(names);
  const std::string start = named                      ? fmt::format("{}", fmt::join(names, " "))
                            : table.width() < 8        ? "t[s] x y z"
                            : table.width() == 13      ? "t[ns] - - - x - - - y - - - z"
                            : table.separator() == ' ' ? "t[ns] x y z qx qy qz qw"
                                                       : "t[ns] x y z qw qx qy qz";
  return fmt::format(
      "TUM (8 columns between spaces, in s and m), KITTI (12), a header of known names with their units "
      "(gaitslam "
      "score --help lists them), or these names in order: --columns \"{}\"",
      start);
}

double coordinate(const TableRow& row, const Column& column) {
  const double value = row.number(column);
  if (!(std::abs(value) <= 1e9)) row.fail(column.field, "a position of more than 1e9 m");
  return value;
}

// The columns of a pose. orientation: w, x, y, z, or empty.
struct PoseColumns {
  std::vector<Column> position, stamp, orientation, covariance;

  explicit PoseColumns(const Table& table)
      : position(table.required(Quantity::position)),
        stamp(table.required(Quantity::time)),
        orientation(table.columns(Quantity::orientation)),
        covariance(table.columns(Quantity::covariance)) {}

  Eigen::Isometry3d pose(const TableRow& row) const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    if (const auto& c = orientation; !c.empty()) {
      const Eigen::Quaterniond q(row.number(c[0]), row.number(c[1]), row.number(c[2]), row.number(c[3]));
      if (std::abs(q.norm() - 1) > 1e-2)
        row.fail(
            std::min(c[0].field, c[1].field),
            "the quaternion has length {:.3g}, expected 1; to read only positions: --columns \"t[s] x y z\"",
            q.norm());
      X.linear() = q.normalized().toRotationMatrix();
    }
    for (std::size_t axis = 0; axis < 3; ++axis) X.translation()[int(axis)] = coordinate(row, position[axis]);
    return X;
  }

  std::optional<Matrix6d> covariance_of(const TableRow& row) const {
    if (covariance.empty() || covariance.back().field >= row.fields()) return std::nullopt;
    Matrix6d P = Matrix6d::Zero();
    auto element = covariance.begin();
    for_each_covariance([&](int i, int j) { P(i, j) = P(j, i) = row.number(*element++); });
    return P;
  }

  // Returns whether a row has no position, as written by some programs while they are lost.
  bool lacks_position(const TableRow& row) const {
    return std::ranges::all_of(position, [&](const Column& column) {
      const auto value = parse_number<double>(row.text(column.field));
      return row.text(column.field).empty() || (value && std::isnan(*value));
    });
  }
};

void warn(TrajectoryFile& read, const std::string& what) {
  read.warning = read.warning ? *read.warning + "; " + what : what;
}

// Adds a row. Throws FileError if its stamp is not after the previous one.
void add(TrajectoryFile& read, const TableRow& row, TumRow pose) {
  if (!read.rows.empty() && pose.t <= read.rows.back().t)
    row.fail(0, "{}", not_rising(read.rows.back().t, pose.t));
  pose.line = row.line();
  read.rows.push_back(std::move(pose));
}

TrajectoryFile read_poses(const Table& table) {
  const PoseColumns columns(table);
  TrajectoryFile read{table.names(), {}};
  for (std::size_t i = 0; i < 3; ++i) read.position[i] = columns.position[i].field;
  read.has_orientation = !columns.orientation.empty();
  read.rows.reserve(table.rows().size());
  std::size_t lost = 0;
  for (const TableRow& row : table.rows()) {
    if (row.fields() != table.width() && !(row.fields() == 8 && !columns.covariance.empty()))
      row.fail("expected {} numbers, found {}", table.width(), row.fields());
    if (columns.lacks_position(row)) {
      ++lost;
      continue;
    }
    const nanoseconds t = table.stamp(row, columns.stamp);
    if (&row == &table.rows().back() && read.rows.size() > 1 && t == read.rows.back().t) {
      warn(read, "its last pose repeats the previous stamp and is skipped");
      continue;
    }
    const Eigen::Isometry3d X = columns.pose(row);
    add(read, row, {{t, X}, columns.covariance_of(row)});
  }
  if (lost > 0) warn(read, counted(lost, "line") + " without a position skipped");
  if (read.rows.empty()) throw FileError(table.file(), "contains no pose: every position is missing or NaN");
  return read;
}

Eigen::Isometry3d kitti_pose(const TableRow& row) {
  if (row.fields() != 12) row.fail("expected 12 numbers, found {}", row.fields());
  Eigen::Matrix3d R;
  for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = row.number(std::size_t(i / 3 * 4 + i % 3));
  if (!(R.transpose() * R).isIdentity(1e-2) || R.determinant() < 0)
    row.fail(0, "the first three columns are not a rotation");
  Eigen::Isometry3d X(Eigen::Quaterniond(R).normalized());
  X.translation() = Eigen::Vector3d(coordinate(row, {3}), coordinate(row, {7}), coordinate(row, {11}));
  return X;
}

TrajectoryFile read_kitti(const Table& table) {
  TrajectoryFile read;
  const fs::path file = table.file().parent_path() / "times.txt";
  std::optional<Table> times;
  if (fs::exists(file)) times.emplace(file, expected_poses);
  if (times && times->rows().size() != table.rows().size())
    throw FileError(file, "has {} times for {} poses", times->rows().size(), table.rows().size());
  read.counts_frames = !times;
  for (const TableRow& row : table.rows()) {
    const std::size_t i = read.rows.size();
    const nanoseconds t = times ? times->stamp(times->rows()[i], {{0, 1e9}}) : std::chrono::seconds(i);
    add(read, times ? times->rows()[i] : row, {{t, kitti_pose(row)}, std::nullopt});
  }
  return read;
}

TrajectoryFile read(Table& table) {
  if (!table.is_named()) {
    const bool spaces = table.separator() == ' ';
    if (spaces && table.width() == 12) return read_kitti(table);
    if (table.separator() == ',')
      table.fail("no header names the comma-separated columns (decimal commas need semicolons or tabs)");
    if (!spaces || (table.width() != 8 && table.width() != 20)) table.fail("no header names its columns");
    table.name(table.width() == 8 ? kTum : kTumCovariance);
  }
  return read_poses(table);
}

}  // namespace

const char* const kTumCovarianceHeader =
    "# timestamp(s) tx ty tz qx qy qz qw Pr11 Pr12 Pr13 Pr22 Pr23 Pr33 Pt11 Pt12 Pt13 Pt22 Pt23 Pt33\n";

std::string tum_row(nanoseconds t, const Eigen::Isometry3d& X) { return tum_pose(t, X) + "\n"; }

std::string tum_row(nanoseconds t, const Eigen::Isometry3d& X, const Matrix6d& covariance) {
  std::string text = tum_pose(t, X);
  for_each_covariance([&](int row, int column) { text += fmt::format(" {}", covariance(row, column)); });
  return text + "\n";
}

Eigen::Isometry3d interpolate(const TimedPose& a, const TimedPose& b, nanoseconds t) {
  const double s = double((t - a.t).count()) / double((b.t - a.t).count());
  const Eigen::Quaterniond qa(a.X.linear()), qb(b.X.linear());
  Eigen::Isometry3d X(qa.slerp(s, qb).normalized());
  X.translation() = (1 - s) * a.X.translation() + s * b.X.translation();
  return X;
}

std::vector<TumRow> read_tum(const fs::path& file) {
  Table table(file, expected_poses);
  return table.rows().empty() ? std::vector<TumRow>{} : read(table).rows;
}

TrajectoryFile read_trajectory(const fs::path& file, const std::string& columns) {
  Table table(file, expected_poses, columns);
  if (table.rows().empty()) throw FileError(file, "contains no pose");
  return read(table);
}

}  // namespace sim::files
