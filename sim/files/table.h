// Tables of other programs: a header or the user names every column that is used. Nothing is inferred from
// values.
#pragma once

#include <chrono>

#include "sim/files/csv.h"

namespace sim::files {

/// Returns a decimal number in some unit (1.4e+18 is accepted) converted to ns exactly, unlike a double.
/// Returns nothing if the text is not a number or the time is more than 9e18 ns.
std::optional<std::chrono::nanoseconds> parse_stamp(std::string_view text, double ns_per_unit);

/// Returns what is wrong with a stamp that is not later than the previous one.
std::string not_rising(std::chrono::nanoseconds before, std::chrono::nanoseconds stamp);

/// Returns the median step between consecutive stamps, or 0 for fewer than two.
std::chrono::nanoseconds median_step(const std::vector<std::chrono::nanoseconds>& stamps);

enum class Quantity { time, position, orientation, angular_rate, acceleration, covariance };

/// A column of a table: its number, and the factor from its unit to ns, m, rad/s, m/s², m² or rad².
struct Column {
  std::size_t field;
  double factor = 1;
};

/// A row of a table. Its fields end at the separator; ' ' stands for spaces and tabs.
class TableRow : public Row {
 public:
  TableRow(std::shared_ptr<const fs::path> file, std::size_t line, std::string_view text, char separator);
  double number(const Column& column) const { return column.factor * Row::number(column.field); }
  using Row::number;
};

/// An external table in UTF-8. Columns are separated by semicolons, tabs, commas or spaces; decimal commas
/// are accepted if the separator is a semicolon or a tab. Lines that start with # or % are comments, except
/// the header.
class Table {
 public:
  /// Describes the expected table in an error message.
  using Expected = std::string (*)(const Table& table);

  /// columns: names of the columns in order, as in "t[ns] x[mm] y[mm] - qw"; they replace the header. Throws
  /// FileError.
  Table(const fs::path& file, Expected expected, const std::string& columns = {});
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

  const fs::path& file() const { return *file_; }
  const std::vector<TableRow>& rows() const { return rows_; }
  std::size_t width() const { return width_; }  ///< fields of the longest row
  char separator() const { return separator_; }
  bool is_named() const { return !titles_.empty(); }
  /// Names the columns. Throws FileError for an unknown name.
  void name(const std::string& columns);
  /// Returns the columns of a quantity: x, y, z; w, x, y, z; the upper triangles of the orientation's and the
  /// position's covariance; the stamp and, if it has two columns, its rest. Empty if no column has such a
  /// name. Throws FileError as fail() does if a column is missing, named twice or has an unknown unit.
  std::vector<Column> columns(Quantity quantity) const;
  /// Returns columns(). Throws FileError if there are none.
  std::vector<Column> required(Quantity quantity) const;
  /// Returns the names as name() reads them, one for each field; a stamp without unit is in ns.
  std::vector<std::string> names() const;
  /// Returns the stamp of a row in these columns. Throws FileError, as fail() does beyond 9e9 s.
  std::chrono::nanoseconds stamp(const TableRow& row, const std::vector<Column>& columns) const;
  /// Throws FileError: why, the first row, and what was expected.
  [[noreturn]] void fail(const std::string& why) const;

 private:
  struct Title {
    std::string name, unit;
    std::optional<Quantity> quantity = {};  // absent: unknown name
    std::size_t axis = 0;                   // place in columns()
    double factor = 1;                      // from a name that defines its unit; 0: the unit must be stated
  };
  Title parse(std::string_view text) const;
  std::vector<Title> titles_of(std::string_view line, char separator) const;
  bool is_header(const std::vector<Title>& titles) const;
  double factor(const Title& title) const;

  std::shared_ptr<const fs::path> file_;
  Expected expected_;
  std::string text_;
  char separator_ = ' ';
  std::vector<TableRow> rows_;
  std::size_t width_ = 0;
  std::vector<Title> titles_;
};

}  // namespace sim::files
