// Strict reading of comma-separated files, row by row: errors name file, line and column.
#pragma once

#include <Eigen/Geometry>

#include "sim/files/text.h"

namespace sim::files {

/// Throws FileError, naming the format or encoding, if a file that starts with these bytes is not UTF-8 text.
void require_utf8(const fs::path& file, std::string_view start);

/// The fields of a line of a file. All members throw FileError.
class Row {
 public:
  std::size_t fields() const { return fields_.size(); }
  std::size_t line() const { return line_number_; }
  std::string_view text(std::size_t field) const { return fields_.at(field); }
  std::int64_t integer(std::size_t field) const;    ///< the whole field, decimal
  double number(std::size_t field) const;           ///< the whole field, finite
  Eigen::Vector3d vector(std::size_t first) const;  ///< three fields
  Eigen::Isometry3d pose(std::size_t first) const;  ///< twelve fields: position, then rotation by rows

  /// Throws FileError at a field. why: a format string and its arguments.
  template <typename... T>
  [[noreturn]] void fail(std::size_t field, fmt::format_string<T...> why, T&&... values) const {
    throw FileError(*file_, line_number_, std::size_t(fields_.at(field).data() - begin_) + 1,
                    fmt::format(why, std::forward<T>(values)...));
  }
  /// Throws FileError at the line.
  template <typename... T>
  [[noreturn]] void fail(fmt::format_string<T...> why, T&&... values) const {
    throw FileError(*file_, line_number_, fmt::format(why, std::forward<T>(values)...));
  }

 protected:
  Row(std::shared_ptr<const fs::path> file, std::size_t line) : file_(std::move(file)), line_number_(line) {}

  std::shared_ptr<const fs::path> file_;
  std::size_t line_number_;
  const char* begin_ = nullptr;  // start of the line
  std::vector<std::string_view> fields_;
};

/// Reads a file line by line. The first line is the header; every other line must have the same number of
/// fields, quoted as in RFC 4180 but without line breaks. All members throw FileError.
class CsvReader : public Row {
 public:
  /// A file written by the program: the first line must be one of `headers`, and each line ends with a line
  /// feed (a last line without one was cut off).
  CsvReader(const fs::path& file, const std::vector<std::string>& headers);

  /// An external file with any header. Ignores whitespace around fields, empty lines, and a missing final
  /// line feed.
  explicit CsvReader(const fs::path& file) : CsvReader(file, Writer::other) {}

  const std::vector<std::string>& titles() const { return titles_; }  ///< titles of the header's columns
  bool next();          ///< reads the next row; false at the end of the file
  double part() const;  ///< fraction of the file's bytes read so far, 0 to 1

 private:
  enum class Writer { own, other };
  CsvReader(const fs::path& file, Writer writer);
  bool read_line();
  void split();
  std::size_t split_quoted(std::size_t begin);  // returns the end of the field

  InputFile input_;
  std::string_view piece_;  // rest of the current piece
  bool strict_;
  std::uintmax_t read_ = 0;  // bytes
  std::vector<std::string> titles_;
  std::string line_;
};

/// Returns the text as a field, quoted as in RFC 4180 if needed. Line breaks become spaces.
std::string csv_field(std::string_view text);
/// Returns csv_field() of an untrusted name, made safe for terminals and spreadsheets. Control characters
/// become '?', and formulas get a leading apostrophe; numbers stay unchanged.
std::string neutral_field(const std::string& text);
/// Returns the fewest digits that round-trip, separated by commas.
std::string csv_fields(const Eigen::Vector3d& v);
/// Returns the twelve fields that CsvReader::pose reads: position, then rotation by rows.
std::string csv_fields(const Eigen::Isometry3d& X);
/// Returns the twelve column titles of the pose X_AB in the style of EuRoC: pose_columns("PC") for X_PC.
std::string pose_columns(const std::string& frames);

}  // namespace sim::files
