// Strict reading of comma-separated files, row by row: every complaint names file, line and column.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/files/text.h"

namespace sim::files {

/// Reads a file whose first row is its header. Each row must have as many fields as the header. A field that
/// begins with a quote is one of RFC 4180: it ends with a quote, quotes in it are doubled, and commas and
/// line feeds are part of it. Complaints name the line in which the row begins. Memory: one row. All members
/// throw FileError.
class CsvReader {
 public:
  /// A file of the program's own: the first line must be one of `headers`, and each line ends with a line
  /// feed (a last line without one was cut off).
  CsvReader(const std::filesystem::path& file, const std::vector<std::string>& headers);

  /// A file that another program may have written, with any header. Blanks around a field and empty lines do
  /// not count, and the last line feed may be missing.
  explicit CsvReader(const std::filesystem::path& file) : CsvReader(file, Writer::other) {}

  /// A file that another program may have written, whose header begins with # and has at least so many
  /// columns.
  CsvReader(const std::filesystem::path& file, std::size_t least_fields);

  std::size_t header() const { return header_; }  ///< which of the headers the file has
  const std::vector<std::string>& titles() const {
    return titles_;
  }                                                      ///< of the columns, as the header has them
  std::size_t fields() const { return fields_.size(); }  ///< of the row
  bool next();                                           ///< reads the next row; false at the end of the file
  double part() const;                                   ///< of the file's bytes that were read, 0 to 1

  std::string_view text(std::size_t field) const { return fields_.at(field); }
  std::int64_t integer(std::size_t field) const;    ///< the whole field, decimal
  double number(std::size_t field) const;           ///< the whole field, finite
  Eigen::Vector3d vector(std::size_t first) const;  ///< three fields
  Eigen::Isometry3d pose(std::size_t first) const;  ///< twelve fields: position, then rotation by rows
  [[noreturn]] void fail(std::size_t field,
                         const std::string& why) const;  ///< FileError at a field of this row

 private:
  enum class Writer { own, other };
  CsvReader(const std::filesystem::path& file, Writer writer);
  [[noreturn]] void fail_length() const;
  bool read_line(std::string& line);
  bool read_row();
  void split();
  std::size_t split_quoted(std::size_t begin);  // where the field ends
  void trim();

  std::filesystem::path file_;
  InputFile input_;
  std::string_view piece_;  // what is left of the piece at hand
  bool strict_;
  std::uintmax_t read_ = 0;                               // bytes
  std::size_t header_ = 0, line_number_ = 1, lines_ = 0;  // the line in which the row begins; of the row
  std::vector<std::string> titles_;
  std::string line_;
  std::vector<std::string_view> fields_;
};

/// A text as a field: quoted as RFC 4180 wants it where it has to be, so that any text is read back.
std::string csv_field(std::string_view text);
/// Shortest decimals that read back to the same bits, separated by commas.
std::string csv_fields(const Eigen::Vector3d& v);
/// Position, then rotation by rows: the twelve fields that CsvReader::pose reads.
std::string csv_fields(const Eigen::Isometry3d& X);
/// The twelve column titles of the pose X_AB, in the style of EuRoC: pose_columns("PC") for X_PC.
std::string pose_columns(const std::string& frames);

}  // namespace sim::files
