// A table for the terminal, no wider than asked for.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace sim::files {

inline constexpr std::size_t kTerminalWidth = 100;

/// naming: the first columns, which say what a row is of. text: so many of the first columns, and with
/// last_text the last one, are aligned to the left, the others to the right.
struct TableShape {
  std::size_t naming = 1, text = 1;
  bool last_text = false;
  std::size_t width = kTerminalWidth;
};

/// Rows of cells, all of the same length; the first row has the titles. Columns are as wide as they need to
/// be; an empty line stands where the first cell changes. Where the table is too wide, long titles are broken
/// after '_' and '.'; where that is not enough, the columns that do not fit follow in further tables, each
/// beginning with the naming columns.
std::string text_table(const std::vector<std::vector<std::string>>& rows, const TableShape& shape);

}  // namespace sim::files
