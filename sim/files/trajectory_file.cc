#include "sim/files/trajectory_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/files/columns.h"

namespace sim::files {
namespace {

using std::chrono::nanoseconds;

constexpr std::string_view kBlank = " \t\r";

// One line. Its fields end at the separator; ' ' stands for spaces and tabs. Errors name file, line and
// column.
class Line : public Row {
 public:
  Line(std::shared_ptr<const fs::path> file, std::size_t number, std::string_view text, char separator)
      : Row(std::move(file), number), separator_(separator) {
    begin_ = text.data();
    if (text.find_first_not_of(kBlank) == text.npos) return;
    for (std::size_t at = 0; at <= text.size();) {
      if (separator == ' ' && (at = text.find_first_not_of(kBlank, at)) == text.npos) break;
      const std::size_t end =
          std::min(separator == ' ' ? text.find_first_of(kBlank, at) : text.find(separator, at), text.size());
      std::string_view field = text.substr(at, end - at);
      field.remove_prefix(std::min(field.find_first_not_of(kBlank), field.size()));
      fields_.push_back(field.substr(0, field.find_last_not_of(kBlank) + 1));
      at = end + 1;
    }
  }

  bool is_comment() const { return fields_.empty() || fields_[0].starts_with('#'); }
  bool has_commas() const { return separator_ == ','; }
  char separator() const { return separator_; }
  void drop_last() { fields_.pop_back(); }

  // Returns whether a field exists and is empty or NaN.
  bool is_absent(const Column& column) const {
    if (column.field >= fields()) return false;
    const auto value = parse_number<double>(text(column.field));
    return text(column.field).empty() || (value && std::isnan(*value));
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

 private:
  char separator_;
};

// Returns what separates the fields of a line: ';' or ',' if it contains them, else ' ' for whitespace.
// Commas within at least four numbers separated by whitespace are decimal commas.
char separator_of(std::string_view line) {
  if (line.find(';') != line.npos) return ';';
  if (line.find(',') == line.npos) return ' ';
  const Line pieces(nullptr, 0, line, ' ');
  const auto may_be_decimal = [&](std::size_t field) {
    const std::string_view piece = pieces.text(field);
    const std::size_t comma = piece.find(',');
    return comma == piece.npos ||
           (comma > 0 && comma + 1 < piece.size() && piece.find(',', comma + 1) == piece.npos);
  };
  for (std::size_t field = 0; field < pieces.fields(); ++field)
    if (!may_be_decimal(field)) return ',';
  return pieces.fields() >= 4 ? ' ' : ',';
}

// Normalizes the numbers in a line of data, character by character so that columns in errors stay correct:
// decimal commas become points, quotes become spaces.
void make_plain(char* begin, char* end, char separator) {
  bool quoted = false;
  for (char* c = begin; c != end; ++c)
    if (*c == '"')
      quoted = !quoted, *c = ' ';
    else if (*c == ',' && (quoted || separator != ','))
      *c = '.';
}

// The lines of a file that are neither blank nor comments. header: the last line of column titles before the
// poses, whether it is a comment or not.
struct Lines {
  explicit Lines(const fs::path& file_) : file(file_), text(plain_text(file, read_text(file))) {
    const auto shared = std::make_shared<const fs::path>(file);
    std::size_t number = 0;
    std::optional<char> separator;  // as in the first line of data
    for (std::size_t begin = 0, end; begin < text.size(); begin = end + 1) {
      end = std::min(text.find('\n', begin), text.size());
      const std::string_view line_text = std::string_view(text).substr(begin, end - begin);
      const bool is_data =
          line_text.find_first_of("0123456789+-.\"nN") == line_text.find_first_not_of(kBlank);
      const char here = separator.value_or(separator_of(line_text));
      ++number;
      if (is_data) make_plain(text.data() + begin, text.data() + end, here);
      Line line(shared, number, line_text, here);
      if (lines.empty() && line.fields() >= 3 && !parse_number<double>(line.text(0)))
        if (Header titles(file, number, line_text); titles.are_titles()) {
          header.emplace(std::move(titles));
          continue;
        }
      if (line.is_comment()) continue;
      if (!separator) separator = here;
      lines.push_back(std::move(line));
    }
    const auto ends_empty = [](const Line& line) {
      return line.separator() != ' ' && line.text(line.fields() - 1).empty();
    };
    if (std::ranges::all_of(lines, ends_empty))  // every line ends with a separator
      for (Line& line : lines) line.drop_last();
    if (header && !lines.empty() && !header->fit(lines.front().fields(), lines.front().separator() != ' '))
      header.reset();
  }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  const fs::path file;
  std::string text;
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

// Calls `each` with row and column for the upper triangle of the orientation's block, then of the position's.
void for_each_covariance(const auto& each) {
  for (const int first : {0, 3})
    for (int row = first; row < first + 3; ++row)
      for (int column = row; column < first + 3; ++column) each(row, column);
}

// The columns of a pose. orientation: w, x, y, z, or empty.
struct PoseColumns {
  StampColumns stamp;
  std::vector<Column> position{{1}, {2}, {3}}, orientation{{7}, {4}, {5}, {6}};
  std::optional<CovarianceColumns> covariance = {};

  /// As named in the header, else in the order of EuRoC (with commas) or TUM.
  explicit PoseColumns(const Lines& text) {
    const std::size_t n = text.lines.front().fields();
    const bool commas = text.lines.front().has_commas();
    const auto& header = text.header;
    const bool twenty = std::ranges::count(text.lines, 20u, &Line::fields) > 0;
    if (header && (!twenty || header->size() > 8))
      covariance = header->covariance_columns(twenty);
    else if (twenty && !commas)
      covariance = in_order();
    if (commas) orientation = {{4}, {5}, {6}, {7}};
    if ((n < 8 || text.names_position()) && !text.names_orientation() && n != 20) orientation.clear();
    if (!header) return;
    stamp = header->stamp_columns();
    position = header->columns(Quantity::position, "xyz", 1);
    if (covariance && position[0].factor != 1 &&
        std::ranges::any_of(covariance->elements, [](const auto& e) { return !e.has_unit; }))
      throw FileError(text.file, "its header states a unit for the positions but none for the covariance");
    if (orientation.empty()) return;
    orientation = header->columns(Quantity::orientation, commas ? "wxyz" : "xyzw", 4);
    if (!commas) std::rotate(orientation.begin(), orientation.end() - 1, orientation.end());
  }

  static CovarianceColumns in_order() {
    CovarianceColumns columns;
    std::size_t field = 8;
    for_each_covariance([&](int row, int column) {
      columns.elements.push_back({row, column, {field++}, true});
    });
    return columns;
  }

  /// The number of fields that a line needs without a covariance; all(): with one.
  std::size_t least() const {
    std::size_t last = std::max(stamp.field, stamp.rest.value_or(0));
    for (const auto* columns : {&position, &orientation})
      for (const Column& column : *columns) last = std::max(last, column.field);
    return last + 1;
  }
  std::size_t all() const {
    std::size_t most = least();
    if (covariance)
      for (const auto& element : covariance->elements) most = std::max(most, element.of.field + 1);
    return most;
  }

  Eigen::Isometry3d pose(const Line& line) const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    if (const auto& c = orientation; !c.empty()) {
      const Eigen::Quaterniond q(line.number(c[0].field), line.number(c[1].field), line.number(c[2].field),
                                 line.number(c[3].field));
      if (std::abs(q.norm() - 1) > 1e-2)
        line.fail(std::min(c[0].field, c[1].field), "the quaternion does not have length 1");
      X.linear() = q.normalized().toRotationMatrix();
    }
    for (int axis = 0; axis < 3; ++axis)
      X.translation()[axis] = line.coordinate(position[static_cast<std::size_t>(axis)]);
    return X;
  }

  bool has_covariance(const Line& line) const {
    return covariance && std::ranges::any_of(covariance->elements, [&](const auto& element) {
             return element.of.field < line.fields() && !line.text(element.of.field).empty();
           });
  }

  /// The covariance of a pose, with rotations about the body's axes.
  Matrix6d covariance_of(const Line& line, const Eigen::Isometry3d& X) const {
    Matrix6d P = Matrix6d::Zero(), given = Matrix6d::Zero();
    for (const auto& [row, column, of, has_unit] : covariance->elements) {
      const double value = of.factor * line.number(of.field);
      if (given(row, column) == 1 && std::abs(value - P(row, column)) > 1e-6 * std::abs(value))
        line.fail(of.field, "the covariance is not symmetric");
      P(row, column) = P(column, row) = value;
      given(row, column) = given(column, row) = 1;
    }
    if (!covariance->fixed_axes) return P;
    Matrix6d J = Matrix6d::Identity();
    J.topLeftCorner<3, 3>() = X.linear().transpose();
    return J * P * J.transpose();
  }
};

Eigen::Isometry3d kitti_pose(const Line& line) {
  if (line.fields() != 12) line.fail("expected 12 numbers, found {}", line.fields());
  Eigen::Matrix3d R;
  for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = line.number(static_cast<std::size_t>(i / 3 * 4 + i % 3));
  if (!(R.transpose() * R).isIdentity(1e-2) || R.determinant() < 0)
    line.fail(0, "the first three columns are not a rotation");
  Eigen::Isometry3d X(Eigen::Quaterniond(R).normalized());
  X.translation() = Eigen::Vector3d(line.coordinate({3}), line.coordinate({7}), line.coordinate({11}));
  return X;
}

void warn(TrajectoryFile& read, const std::string& what) {
  read.warning = read.warning ? *read.warning + "; " + what : what;
}

// Drops a last pose that repeats the previous stamp. Throws FileError if stamps otherwise do not increase.
void settle_stamps(TrajectoryFile& read, const std::vector<Line>& lines) {
  std::vector<TumRow>& rows = read.rows;
  if (rows.size() > 2 && rows.back().t == rows[rows.size() - 2].t) {
    rows.pop_back();
    warn(read, "its last pose repeats the previous stamp and is left out");
  }
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].t <= rows[i - 1].t) lines[i].fail(0, "{}", not_rising(rows[i - 1].t, rows[i].t));
}

// Throws FileError if the stamps cannot be in the unit that the header states.
const TimeUnit& unit_of(const Lines& text, const StampColumns& columns) {
  std::vector<double> stamps;
  for (const Line& line : text.lines)
    stamps.push_back(columns.number(line, columns.unit ? *columns.unit : kSeconds));
  return unit_of_stamps(text.file, stamps, columns.unit);
}

// Drops lines without a position, which some programs write while they are lost. Returns how many.
std::size_t drop_absent(std::vector<Line>& lines, const std::vector<Column>& position) {
  return std::erase_if(lines, [&](const Line& line) {
    return std::ranges::all_of(position, [&](const Column& column) { return line.is_absent(column); });
  });
}

// Returns whether no line states an orientation: all quaternions are 0, NaN or empty.
bool lacks_orientations(const std::vector<Line>& lines, const std::vector<Column>& orientation) {
  return !orientation.empty() && std::ranges::all_of(lines, [&](const Line& line) {
    return std::ranges::all_of(orientation, [&](const Column& column) {
      return line.is_absent(column) || parse_number<double>(line.text(column.field)) == 0;
    });
  });
}

TrajectoryFile read_poses(Lines& text, const TimeUnit* stated) {
  const std::size_t fields = text.lines.front().fields();
  const bool commas = text.lines.front().has_commas();
  PoseColumns columns(text);
  const auto may_have = [&](std::size_t n) {  // only some poses may have a covariance
    return commas || n == fields || (columns.covariance && (n == 8 || n == columns.all()));
  };
  if (stated && !columns.stamp.rest) columns.stamp.unit = stated;
  for (const Line& line : text.lines) {
    const std::size_t n = line.fields();
    if (!may_have(n)) line.fail("expected {} numbers, found {}", std::max(fields, columns.all()), n);
    if (const std::size_t least = n == 8 ? columns.least() : columns.all(); n < least)
      line.fail("expected at least {} numbers, found {}", least, n);
  }
  TrajectoryFile read;
  if (const std::size_t lost = drop_absent(text.lines, columns.position))
    warn(read, fmt::format("{} without a position left out", counted(lost, "line")));
  if (text.lines.empty()) throw FileError(text.file, "contains no pose: every position is missing or NaN");
  if (lacks_orientations(text.lines, columns.orientation)) {
    columns.orientation.clear();
    warn(read, "all its quaternions are 0 or absent: only its positions are read");
  }
  const TimeUnit& unit = unit_of(text, columns.stamp);
  read.format = commas ? "EuRoC csv" : "TUM";
  if (columns.covariance) read.format += " with covariance";
  read.stamps = unit.name;
  read.has_orientation = !columns.orientation.empty();
  if (text.lines.front().separator() != ' ' && read.has_orientation && !text.names_orientation())
    warn(read, fmt::format("no header names the quaternion: it is taken for {}, in columns 5 to 8",
                           commas ? "w, x, y, z" : "x, y, z, w"));
  if (commas && !text.header && fields == 20)
    warn(read, "no header names columns 9 to 20: a covariance in them is not read");
  for (const Line& line : text.lines)
    read.rows.push_back({{line.stamp(columns.stamp, unit)}, std::nullopt, line.line()});
  settle_stamps(read, text.lines);
  for (std::size_t i = 0; i < read.rows.size(); ++i) {
    const Line& line = text.lines[i];
    read.rows[i].X = columns.pose(line);
    if (columns.has_covariance(line)) read.rows[i].covariance = columns.covariance_of(line, read.rows[i].X);
  }
  const auto turned = [&](const TumRow& row) { return row.X.linear() != read.rows.front().X.linear(); };
  if (read.has_orientation && read.rows.size() > 2 && std::ranges::none_of(read.rows, turned))
    warn(read, "all its orientations are the same: are they unknown?");
  return read;
}

// Explains an error in a file that has commas but no decimal point.
TrajectoryFile read_poses_or_explain(Lines& text, const TimeUnit* stated) try {
  return read_poses(text, stated);
} catch (const FileError& error) {
  if (text.lines.empty() || !text.lines.front().has_commas() || text.text.find('.') != text.text.npos ||
      (text.header && text.header->size() == text.lines.front().fields()))
    throw;
  throw FileError(text.file,
                  "has commas and no decimal point: if the commas are decimal, other "
                  "characters must separate its columns; else {}",
                  error.what());
}

TrajectoryFile read_kitti(const Lines& text) {
  TrajectoryFile read{"KITTI", "frame numbers", {}};
  for (const Line& line : text.lines)
    read.rows.push_back({{std::chrono::seconds(read.rows.size()), kitti_pose(line)}, std::nullopt});
  const fs::path file = text.file.parent_path() / "times.txt";
  if (!fs::exists(file)) return read;
  const Lines times(file);
  if (times.lines.size() != read.rows.size())
    throw FileError(file, "has {} times for {} poses", times.lines.size(), read.rows.size());
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
  Lines text(file);
  if (text.lines.empty()) return {};
  if (const std::size_t n = text.lines.front().fields(); n != 4 && n != 8 && n != 20)
    text.lines.front().fail("expected 8 or 20 numbers, found {}", n);
  return read_poses(text, &kSeconds).rows;
}

TrajectoryFile read_trajectory(const fs::path& file) {
  Lines text(file);
  if (text.lines.empty()) throw FileError(file, "contains no pose");
  const Line& first = text.lines.front();
  const std::size_t n = first.fields();
  if (!text.header) first.number(0);
  const bool named = text.names_position(), commas = first.has_commas();
  if (n == 12 && !commas && !text.names_orientation()) return read_kitti(text);
  if (commas && n < 8 && n != 4 && !named) first.fail("expected at least 8 numbers, found {}", n);
  if (n == 4 || n == 8 || n == 20 || named || commas) return read_poses_or_explain(text, nullptr);
  first.fail("has {}, expected 8 or 20 (TUM), 12 (KITTI), or a csv (EuRoC) with commas",
             counted(n, "number"));
}

}  // namespace sim::files
