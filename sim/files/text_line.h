// Strict reading of lines of numbers: errors name file, line and column.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/files/columns.h"
#include "sim/files/text.h"

namespace sim::files {

/// One line; blanks, tabs or commas separate its fields. All members throw FileError.
class TextLine {
 public:
  /// number: of the line, from 1. The text must outlive the line.
  TextLine(const std::filesystem::path& file, std::size_t number, std::string_view text);

  std::size_t size() const { return fields_.size(); }
  /// The line is blank or starts with #.
  bool is_comment() const { return fields_.empty() || fields_[0].text.front() == '#'; }
  bool has_commas() const { return has_commas_; }
  std::string_view text(std::size_t field) const { return fields_.at(field).text; }
  double number(std::size_t field) const;  ///< the whole field, finite

  /// Exact to the nanosecond, unlike a double.
  std::chrono::nanoseconds stamp(std::size_t field, const TimeUnit& unit) const;

  [[noreturn]] void fail(std::size_t field, const std::string& why) const;
  [[noreturn]] void fail(const std::string& why) const;

 private:
  struct Field {
    std::string_view text;
    std::size_t column;  // from 1
  };
  std::filesystem::path file_;
  std::size_t number_;
  bool has_commas_;
  std::vector<Field> fields_;
};

/// The lines of a whole file that are neither blank nor comments, after a byte order mark.
class TextLines {
 public:
  /// Throws FileError.
  explicit TextLines(const std::filesystem::path& file);
  TextLines(const TextLines&) = delete;
  TextLines& operator=(const TextLines&) = delete;

  const std::vector<TextLine>& lines() const { return lines_; }
  /// The titles of the columns: the last line before the poses, a comment or not, that has such titles.
  const std::optional<Header>& header() const { return header_; }

 private:
  std::string text_;
  std::optional<Header> header_;
  std::vector<TextLine> lines_;
};

}  // namespace sim::files
