#include "sim/files/text_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/files/text.h"

namespace sim::files {
namespace {

using Rows = std::vector<std::vector<std::string>>;

constexpr std::size_t kGap = 2;

/// Returns the title in lines of at most `width`, broken after '_' and '.'; longer parts stay whole.
std::vector<std::string> broken(const std::string& title, std::size_t width) {
  std::vector<std::string> lines{""};
  for (std::size_t from = 0; from < title.size();) {
    const std::size_t to = std::min(title.find_first_of("_.", from), title.size() - 1) + 1;
    const std::string part = title.substr(from, to - from);
    if (!lines.back().empty() && lines.back().size() + part.size() > width) lines.emplace_back();
    lines.back() += part;
    from = to;
  }
  return lines;
}

/// One column: the lines of its title, and its cells.
struct TableColumn {
  std::vector<std::string> title, cells;
  bool left = false;

  std::size_t cells_width() const {
    std::size_t width = 0;
    for (const std::string& cell : cells) width = std::max(width, cell.size());
    return width;
  }
  std::size_t width() const {
    std::size_t width = cells_width();
    for (const std::string& line : title) width = std::max(width, line.size());
    return width;
  }
};
using Columns = std::vector<TableColumn>;

/// Neither a name's control characters nor its line feeds and tabs reach the terminal.
std::string plain(const std::string& cell) {
  std::string text = sanitize(cell);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\t'; }, '?');
  return text;
}

Columns columns_of(const Rows& rows, const TableShape& shape) {
  Columns columns(rows.at(0).size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    columns[i].left = i < shape.text || (shape.last_text && i + 1 == columns.size());
    columns[i].title = {plain(rows[0][i])};
    for (std::size_t k = 1; k < rows.size(); ++k) columns[i].cells.push_back(plain(rows[k][i]));
  }
  return columns;
}

std::size_t width_of(const Columns& columns) {
  std::size_t width = 0;
  for (const TableColumn& column : columns) width += column.width() + kGap;
  return width < kGap ? 0 : width - kGap;
}

void break_titles(Columns& columns) {
  constexpr std::size_t kLeast = 10;
  for (TableColumn& column : columns)
    column.title = broken(column.title[0], std::max(kLeast, column.cells_width()));
}

/// Cells of one line of a table, without spaces at its end.
std::string line_of(const Columns& columns, const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i > 0) line += std::string(kGap, ' ');
    line += columns[i].left ? fmt::format("{:<{}}", cells[i], columns[i].width())
                            : fmt::format("{:>{}}", cells[i], columns[i].width());
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

std::string drawn(const Columns& columns) {
  std::size_t head = 0;
  for (const TableColumn& column : columns) head = std::max(head, column.title.size());
  std::string text;
  std::vector<std::string> cells(columns.size());
  for (std::size_t line = 0; line < head; ++line) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::size_t above = head - columns[i].title.size();  // titles stand on the first row
      cells[i] = line < above ? "" : columns[i].title[line - above];
    }
    text += line_of(columns, cells);
  }
  const std::vector<std::string>& first = columns[0].cells;
  for (std::size_t row = 0; row < first.size(); ++row) {
    if (row > 0 && first[row] != first[row - 1]) text += "\n";
    for (std::size_t i = 0; i < columns.size(); ++i) cells[i] = columns[i].cells[row];
    text += line_of(columns, cells);
  }
  return text;
}

}  // namespace

std::string text_table(const Rows& rows, const TableShape& shape) {
  Columns all = columns_of(rows, shape);
  if (width_of(all) > shape.width) break_titles(all);
  const auto values = all.begin() + static_cast<std::ptrdiff_t>(std::min(shape.naming, all.size()));
  Columns table(all.begin(), values);
  std::string text;
  for (auto column = values; column != all.end(); ++column) {
    table.push_back(*column);
    if (width_of(table) <= shape.width || table.size() == shape.naming + 1) continue;
    table.pop_back();
    text += drawn(table) + "\n";
    table.assign(all.begin(), values);
    table.push_back(*column);
  }
  return text + drawn(table);
}

}  // namespace sim::files
