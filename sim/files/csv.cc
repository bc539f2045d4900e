#include "sim/files/csv.h"

#include <fmt/format.h>

#include <algorithm>

namespace sim::files {

void require_utf8(const fs::path& file, std::string_view start) {
  if (start.substr(0, 64).find('\0') != start.npos)
    throw FileError(file, "is compressed, binary, UTF-16 or UTF-32, expected plain text in UTF-8");
}

CsvReader::CsvReader(const fs::path& file, Writer writer)
    : Row(std::make_shared<const fs::path>(file), 0),
      input_(file, kMostOfRows),
      strict_(writer == Writer::own) {
  piece_ = input_.next();
  if (!strict_) require_utf8(file, piece_);
  if (!read_line()) throw FileError(file, "is empty");
  if (!strict_ && line_.starts_with("\xef\xbb\xbf")) line_.erase(0, 3);  // UTF-8's byte order mark
  if (line_.find('\r') != line_.npos) fail("lines end with CR, expected line feeds");
  split();
  titles_.assign(fields_.begin(), fields_.end());
  fields_.clear();
}

CsvReader::CsvReader(const fs::path& file, const std::vector<std::string>& headers)
    : CsvReader(file, Writer::own) {
  if (std::ranges::find(headers, line_) == headers.end())
    fail("expected the header \"{}\", found \"{}\"", headers.front(), line_);
}

bool CsvReader::read_line() {
  constexpr std::size_t kLongestRow = 1 << 20;
  line_.clear();
  ++line_number_;
  for (bool ends = false; !ends && (!piece_.empty() || !(piece_ = input_.next()).empty());) {
    const std::size_t end = std::min(piece_.find('\n'), piece_.size());
    ends = end < piece_.size();
    line_ += piece_.substr(0, end);
    if (line_.size() > kLongestRow) fail("has more than {} characters", kLongestRow);
    piece_.remove_prefix(end + ends);
    read_ += end + ends;
    if (!ends) continue;
    if (line_.ends_with('\r')) line_.pop_back();
    return true;
  }
  if (!line_.empty() && strict_) fail("the last line is cut off: it does not end with a line feed");
  return !line_.empty();
}

double CsvReader::part() const {
  const auto size = double(input_.size());
  return size == 0 ? 0 : std::min(1.0, double(read_) / size);
}

void CsvReader::split() {
  fields_.clear();
  begin_ = line_.data();
  for (std::size_t begin = 0;; ++begin) {
    if (begin < line_.size() && line_[begin] == '"') {
      begin = split_quoted(begin);
    } else {
      const std::size_t end = std::min(line_.find(',', begin), line_.size());
      std::string_view field = std::string_view(line_).substr(begin, end - begin);
      if (!strict_) {  // strips whitespace around it
        field.remove_prefix(std::min(field.find_first_not_of(" \t"), field.size()));
        field = field.substr(0, field.find_last_not_of(" \t") + 1);
      }
      fields_.push_back(field);
      begin = end;
    }
    if (begin == line_.size()) return;
  }
}

std::size_t CsvReader::split_quoted(std::size_t begin) {
  std::size_t from = begin + 1, to = from;
  for (;; ++from, ++to) {
    if (from == line_.size()) fail("a quoted field is not closed");
    if (line_[from] == '"' && (++from == line_.size() || line_[from] != '"')) break;
    line_[to] = line_[from];
  }
  fields_.push_back(std::string_view(line_).substr(begin + 1, to - begin - 1));
  if (from < line_.size() && line_[from] != ',')
    throw FileError(*file_, line_number_, from + 1, "expected a comma after the quoted field");
  return from;
}

bool CsvReader::next() {
  do
    if (!read_line()) return false;
  while (!strict_ && line_.empty());
  split();
  if (fields_.size() != titles_.size()) fail("expected {} fields, found {}", titles_.size(), fields_.size());
  return true;
}

std::int64_t Row::integer(std::size_t field) const {
  const auto value = parse_number<std::int64_t>(text(field));
  if (!value) fail(field, "expected an integer, found \"{}\"", text(field));
  return *value;
}

double Row::number(std::size_t field) const {
  const auto value = parse_finite(text(field));
  if (!value) fail(field, "expected a finite number, found \"{}\"", text(field));
  return *value;
}

Eigen::Vector3d Row::vector(std::size_t first) const {
  return {number(first), number(first + 1), number(first + 2)};
}

Eigen::Isometry3d Row::pose(std::size_t first) const {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = vector(first);
  for (int row = 0; row < 3; ++row)
    X.linear().row(row) = vector(first + 3 + 3 * std::size_t(row)).transpose();
  const Eigen::Matrix3d residual = X.linear() * X.linear().transpose() - Eigen::Matrix3d::Identity();
  if (residual.norm() > 1e-9 || X.linear().determinant() < 0)
    fail(first + 3, "these nine numbers are not a rotation matrix");
  return X;
}

std::string csv_field(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  const bool trimmed = text.empty() || (!is_blank(text.front()) && !is_blank(text.back()));
  if (trimmed && text.find_first_of(",\"\r\n") == text.npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) (quoted += c == '\r' || c == '\n' ? ' ' : c) += c == '"' ? "\"" : "";
  return quoted + "\"";
}

std::string neutral_field(const std::string& text) {
  const std::string name = one_line(text);
  const bool formula = !name.empty() && std::string_view("=+-@").find(name[0]) != std::string_view::npos;
  return csv_field(formula && !parse_number<double>(name) ? "'" + name : name);
}

std::string csv_fields(const Eigen::Vector3d& v) { return fmt::format("{},{},{}", v.x(), v.y(), v.z()); }

std::string csv_fields(const Eigen::Isometry3d& X) {
  std::string fields = csv_fields(Eigen::Vector3d(X.translation()));
  for (int row = 0; row < 3; ++row) fields += "," + csv_fields(Eigen::Vector3d(X.linear().row(row)));
  return fields;
}

std::string pose_columns(const std::string& frames) {
  std::string columns = fmt::format("p_{0}_x [m],p_{0}_y [m],p_{0}_z [m]", frames);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) columns += fmt::format(",R_{}_{}{} []", frames, row, column);
  return columns;
}

}  // namespace sim::files
