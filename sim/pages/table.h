// A comma-separated file of a result.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "slam/observation.h"

namespace sim::pages {

namespace fs = std::filesystem;

using Column = std::vector<double>;

/// Returns the names of columns without units ("p_W_x [m]" becomes p_W_x) and without a '#' at the start.
std::vector<std::string> names_of(std::vector<std::string> titles);

/// A comma-separated file, accessed by column name; extra columns are ignored.
class Table {
 public:
  /// Throws FileError if the file cannot be read, or if it has duplicate columns or a row of different
  /// length.
  explicit Table(const fs::path& file);

  std::size_t rows() const { return rows_; }
  bool has(std::string_view column) const { return columns_.contains(column); }
  /// Returns a column as text. Throws FileError if the column is missing.
  const std::vector<std::string>& text(std::string_view column) const;
  /// Returns a column as numbers; NaN if a field is not a number.
  Column numbers(std::string_view column) const;
  /// Returns a column of nanoseconds, converted to seconds.
  Column seconds(std::string_view column) const;
  /// Returns a column of time stamps. Throws FileError if a field is not one.
  std::vector<slam::Stamp> stamps(std::string_view column) const;

 private:
  fs::path file_;
  std::size_t rows_ = 0;
  std::map<std::string, std::vector<std::string>, std::less<>> columns_;
};

}  // namespace sim::pages
