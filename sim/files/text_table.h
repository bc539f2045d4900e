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

/// Prints rows of cells, all of the same length; the first row has the titles. An empty line separates rows
/// with different first cells. If the table is too wide, long titles are broken after '_' and '.', then
/// remaining columns follow in further tables that repeat the naming columns.
std::string text_table(const std::vector<std::vector<std::string>>& rows, const TableShape& shape);

}  // namespace sim::files
