// A comma-separated file by the names of its columns, whatever other columns it has.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace sim::pages {

/// Titles lose their unit ("p_W_x [m]" is p_W_x) and the first one its '#'.
class Table {
 public:
  /// Throws files::FileError: cannot be read, two columns of one name, a row with another
  /// number of fields than the header.
  explicit Table(const std::filesystem::path& file);

  std::size_t rows() const { return rows_; }
  bool has(std::string_view column) const { return columns_.contains(column); }
  /// As text. Throws files::FileError if there is no such column.
  const std::vector<std::string>& text(std::string_view column) const;
  /// As numbers; not a number where a field holds none.
  std::vector<double> numbers(std::string_view column) const;
  /// Numbers that are nanoseconds, in seconds.
  std::vector<double> seconds(std::string_view column) const;

 private:
  std::filesystem::path file_;
  std::size_t rows_ = 0;
  std::map<std::string, std::vector<std::string>, std::less<>> columns_;
};

}  // namespace sim::pages
