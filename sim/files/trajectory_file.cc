#include "sim/files/trajectory_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/files/columns.h"

namespace sim::files {
namespace {

namespace fs = std::filesystem;
using std::chrono::nanoseconds;

// One line; blanks, tabs or commas separate its fields. Errors name file, line and column.
class Line {
 public:
  Line(const fs::path& file, std::size_t number, std::string_view text)
      : file_(file), number_(number), text_(text) {
    constexpr std::string_view kBlank = " \t\r";
    for (std::size_t at = 0; (at = text.find_first_not_of(kBlank, at)) != text.npos;) {
      const std::size_t end =
          std::min(has_commas() ? text.find(',', at) : text.find_first_of(kBlank, at), text.size());
      const std::string_view field = text.substr(at, end - at);
      fields_.push_back(field.substr(0, field.find_last_not_of(kBlank) + 1));
      at = end + has_commas();
    }
  }

  std::size_t size() const { return fields_.size(); }
  bool is_comment() const { return fields_.empty() || fields_[0].starts_with('#'); }
  bool has_commas() const { return text_.find(',') != text_.npos; }
  std::string_view text(std::size_t field) const { return fields_.at(field); }

  double number(std::size_t field) const {
    const auto value = parse_finite(text(field));
    if (!value) fail(field, fmt::format("expected a finite number, found \"{}\"", text(field)));
    return *value;
  }
  nanoseconds stamp(const StampColumns& columns, const TimeUnit& unit) const {
    number(columns.field);
    const auto t = columns.read(*this, unit);
    if (!t) fail(columns.field, "a time of more than 9e9 s: is it in nanoseconds?");
    return *t;
  }
  double coordinate(const Column& column) const {
    constexpr double kMost_m = 1e9;
    const double value = column.factor * number(column.field);
    if (!(std::abs(value) <= kMost_m)) fail(column.field, "a position of more than 1e9 m");
    return value;
  }

  [[noreturn]] void fail(std::size_t field, const std::string& why) const {
    const auto column = static_cast<std::size_t>(text(field).data() - text_.data()) + 1;
    throw FileError(file_, number_, column, why);
  }
  [[noreturn]] void fail(const std::string& why) const { throw FileError(file_, number_, why); }

 private:
  const fs::path& file_;
  std::size_t number_;
  std::string_view text_;
  std::vector<std::string_view> fields_;
};

// The lines of a file that are neither blank nor comments. header: the last line before the poses, a comment
// or not, that has titles of columns.
struct Lines {
  explicit Lines(const fs::path& file_) : file(file_), text(read_text(file)) {
    std::size_t number = 0;
    for (std::string_view rest = text; !rest.empty();) {
      std::string_view line_text = rest.substr(0, rest.find('\n'));
      rest.remove_prefix(std::min(line_text.size() + 1, rest.size()));
      if (++number == 1 && line_text.starts_with("\xef\xbb\xbf")) line_text.remove_prefix(3);  // UTF-8's mark
      Line line(file, number, line_text);
      if (lines.empty() && line.size() >= 3 && !parse_number<double>(line.text(0)))
        if (Header titles(file, number, line_text); titles.are_titles()) {
          header.emplace(std::move(titles));
          continue;
        }
      if (!line.is_comment()) lines.push_back(std::move(line));
    }
    if (header && !lines.empty() && !header->fit(lines.front().size(), lines.front().has_commas()))
      header.reset();
  }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  const fs::path file;
  const std::string text;
  std::optional<Header> header;
  std::vector<Line> lines;

  bool names_position() const {
    const auto names = [&](char axis) { return header->names_axis(axis); };
    return header && (header->names(Quantity::position) || (names('x') && names('y') && names('z')));
  }
  bool names_orientation() const {
    return header && (header->names(Quantity::orientation) || header->names_axis('w'));
  }
};

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

// Calls `each` with row and column of the upper triangles of the orientation's block, then the position's.
void for_each_covariance(const auto& each) {
  for (const int first : {0, 3})
    for (int row = first; row < first + 3; ++row)
      for (int column = row; column < first + 3; ++column) each(row, column);
}

Matrix6d covariance(const Line& line) {
  Matrix6d P = Matrix6d::Zero();
  std::size_t field = 8;
  for_each_covariance([&](int row, int column) { P(row, column) = P(column, row) = line.number(field++); });
  return P;
}

// The columns of a pose; orientation: w, x, y, z, or none.
struct PoseColumns {
  StampColumns stamp;
  std::vector<Column> position{{1}, {2}, {3}}, orientation{{7}, {4}, {5}, {6}};

  /// As the header names them, else in the order of EuRoC (with commas) or TUM.
  explicit PoseColumns(const Lines& text) {
    const std::size_t n = text.lines.front().size();
    const bool commas = text.lines.front().has_commas();
    const auto& header = text.header;
    if (commas) orientation = {{4}, {5}, {6}, {7}};
    if ((n < 8 || text.names_position()) && !text.names_orientation() && n != 20) orientation.clear();
    if (!header) return;
    stamp = header->stamp_columns();
    position = header->columns(Quantity::position, "xyz", 1);
    if (orientation.empty()) return;
    orientation = header->columns(Quantity::orientation, commas ? "wxyz" : "xyzw", 4);
    if (!commas) std::rotate(orientation.begin(), orientation.end() - 1, orientation.end());
  }

  /// The number of fields that a line needs.
  std::size_t least() const {
    std::size_t last = std::max(stamp.field, stamp.rest.value_or(0));
    for (const auto* columns : {&position, &orientation})
      for (const Column& column : *columns) last = std::max(last, column.field);
    return last + 1;
  }

  Eigen::Isometry3d pose(const Line& line) const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    if (const auto& c = orientation; !c.empty()) {
      const Eigen::Quaterniond q(line.number(c[0].field), line.number(c[1].field), line.number(c[2].field),
                                 line.number(c[3].field));
      if (std::abs(q.norm() - 1) > 1e-2)
        line.fail(std::min(c[0].field, c[1].field), "the quaternion is not of length 1");
      X.linear() = q.normalized().toRotationMatrix();
    }
    for (int axis = 0; axis < 3; ++axis)
      X.translation()[axis] = line.coordinate(position[static_cast<std::size_t>(axis)]);
    return X;
  }
};

Eigen::Isometry3d kitti_pose(const Line& line) {
  if (line.size() != 12) line.fail(fmt::format("expected 12 numbers, found {}", line.size()));
  Eigen::Matrix3d R;
  for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = line.number(static_cast<std::size_t>(i / 3 * 4 + i % 3));
  if (!(R.transpose() * R).isIdentity(1e-2) || R.determinant() < 0)
    line.fail(0, "the first three columns are not a rotation");
  Eigen::Isometry3d X(Eigen::Quaterniond(R).normalized());
  X.translation() = Eigen::Vector3d(line.coordinate({3}), line.coordinate({7}), line.coordinate({11}));
  return X;
}

void warn(TrajectoryFile& read, const char* what) {
  read.warning = read.warning ? *read.warning + "; " + what : what;
}

// Drops a last pose that repeats the stamp before. Throws FileError if stamps do not rise otherwise.
void settle_stamps(TrajectoryFile& read, const std::vector<Line>& lines) {
  std::vector<TumRow>& rows = read.rows;
  if (rows.size() > 2 && rows.back().t == rows[rows.size() - 2].t) {
    rows.pop_back();
    warn(read, "its last pose has the stamp of the one before and is left out");
  }
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].t <= rows[i - 1].t) lines[i].fail(0, not_rising(rows[i - 1].t, rows[i].t));
}

// Throws FileError if the stamps are not in the unit that the header states.
const TimeUnit& unit_of(const Lines& text, const StampColumns& columns) {
  std::vector<double> stamps;
  for (const Line& line : text.lines)
    stamps.push_back(columns.number(line, columns.unit ? *columns.unit : kSeconds));
  return unit_of_stamps(text.file, stamps, columns.unit);
}

TrajectoryFile read_poses(const Lines& text, const TimeUnit* stated) {
  const Line& first = text.lines.front();
  const bool commas = first.has_commas();
  const bool with_covariance = !commas && std::ranges::count(text.lines, 20u, &Line::size) > 0;
  PoseColumns columns(text);
  if (stated && !columns.stamp.rest) columns.stamp.unit = stated;
  for (const Line& line : text.lines) {
    const std::size_t n = line.size();
    if (!commas && n != first.size() && !(with_covariance && (n == 8 || n == 20)))
      line.fail(fmt::format("expected {} numbers, found {}", with_covariance ? 20 : first.size(), n));
    if (n < columns.least())
      line.fail(fmt::format("expected at least {} numbers, found {}", columns.least(), n));
  }
  const TimeUnit& unit = unit_of(text, columns.stamp);
  TrajectoryFile read;
  read.format = commas ? "EuRoC csv" : with_covariance ? "TUM with covariance" : "TUM";
  read.stamps = unit.name;
  read.has_orientation = !columns.orientation.empty();
  if (commas && read.has_orientation && !text.names_orientation())
    read.warning = "no header names the quaternion: it is taken for w, x, y, z, in columns 5 to 8";
  for (const Line& line : text.lines) read.rows.push_back({{line.stamp(columns.stamp, unit)}, std::nullopt});
  settle_stamps(read, text.lines);
  for (std::size_t i = 0; i < read.rows.size(); ++i) {
    const Line& line = text.lines[i];
    read.rows[i].X = columns.pose(line);
    if (with_covariance && line.size() == 20) read.rows[i].covariance = covariance(line);
  }
  const auto turned = [&](const TumRow& row) { return row.X.linear() != read.rows.front().X.linear(); };
  if (read.has_orientation && read.rows.size() > 2 && std::ranges::none_of(read.rows, turned))
    warn(read, "all its orientations are the same: are they unknown?");
  return read;
}

TrajectoryFile read_kitti(const Lines& text) {
  TrajectoryFile read{"KITTI", "frame numbers", {}};
  for (const Line& line : text.lines)
    read.rows.push_back({{std::chrono::seconds(read.rows.size()), kitti_pose(line)}, std::nullopt});
  const fs::path file = text.file.parent_path() / "times.txt";
  if (!fs::exists(file)) return read;
  const Lines times(file);
  if (times.lines.size() != read.rows.size())
    throw FileError(file, fmt::format("has {} times for {} poses", times.lines.size(), read.rows.size()));
  const TimeUnit& unit = unit_of(times, {});
  for (std::size_t i = 0; i < read.rows.size(); ++i) read.rows[i].t = times.lines[i].stamp({}, unit);
  settle_stamps(read, times.lines);
  read.stamps = unit.name;
  return read;
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

std::vector<TumRow> read_tum(const fs::path& file) {
  const Lines text(file);
  if (text.lines.empty()) return {};
  if (const std::size_t n = text.lines.front().size(); n != 4 && n != 8 && n != 20)
    text.lines.front().fail(fmt::format("expected 8 or 20 numbers, found {}", n));
  return read_poses(text, &kSeconds).rows;
}

TrajectoryFile read_trajectory(const fs::path& file) {
  const Lines text(file);
  if (text.lines.empty()) throw FileError(file, "has no pose in it");
  const Line& first = text.lines.front();
  const std::size_t n = first.size();
  if (n == 12 && !first.has_commas()) return read_kitti(text);
  const bool named = text.names_position();
  if (first.has_commas() && n < 8 && n != 4 && !named)
    first.fail(fmt::format("expected at least 8 numbers, found {}", n));
  if (n == 4 || n == 8 || n == 20 || named || first.has_commas()) return read_poses(text, nullptr);
  first.fail(fmt::format("has {}, expected 8 or 20 (TUM), 12 (KITTI), or a csv (EuRoC) with commas",
                         counted(n, "number")));
}

}  // namespace sim::files
