#include "sim/files/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "sim/files/text.h"

namespace sim::files {
namespace {

constexpr std::size_t kGap = 2;

/// One column: the lines of its title, and its cells.
struct TableColumn {
  std::vector<std::string> title, cells;
  bool left = false;

  std::size_t width() const {
    std::size_t width = 0;
    for (const auto* lines : {&title, &cells})
      for (const std::string& line : *lines) width = std::max(width, line.size());
    return width;
  }

  /// Breaks the title after '_' and '.' into lines as wide as the cells; longer parts stay whole.
  void break_title() {
    constexpr std::size_t kLeast = 10;
    const std::string whole = std::exchange(title, {""})[0];
    std::size_t most = kLeast;
    for (const std::string& cell : cells) most = std::max(most, cell.size());
    for (std::size_t from = 0, to; from < whole.size(); from = to) {
      to = std::min(whole.find_first_of("_.", from), whole.size() - 1) + 1;
      if (!title.back().empty() && title.back().size() + to - from > most) title.emplace_back();
      title.back() += whole.substr(from, to - from);
    }
  }
};
using Columns = std::vector<TableColumn>;

/// Neither a name's control characters nor its line feeds and tabs reach the terminal.
std::string plain(const std::string& cell) {
  std::string text = sanitize(cell);
  for (char& c : text)
    if (c == '\n' || c == '\t') c = '?';
  return text;
}

std::size_t width_of(const Columns& columns) {
  std::size_t width = 0;
  for (const TableColumn& column : columns) width += column.width() + (width > 0 ? kGap : 0);
  return width;
}

std::string drawn(const Columns& columns) {
  std::size_t head = 0;
  for (const TableColumn& column : columns) head = std::max(head, column.title.size());
  std::string text;
  const auto add_line = [&](const auto& cell_of) {
    std::string line;
    for (const TableColumn& column : columns)
      line += std::string(line.empty() ? 0 : kGap, ' ') +
              (column.left ? fmt::format("{:<{}}", cell_of(column), column.width())
                           : fmt::format("{:>{}}", cell_of(column), column.width()));
    text += line.erase(line.find_last_not_of(' ') + 1) + "\n";
  };
  for (std::size_t row = 0; row < head; ++row)  // titles stand on the first row of cells
    add_line([&](const TableColumn& column) {
      const std::size_t above = head - column.title.size();
      return row < above ? "" : column.title[row - above];
    });
  const std::vector<std::string>& first = columns[0].cells;
  for (std::size_t row = 0; row < first.size(); ++row) {
    if (row > 0 && first[row] != first[row - 1]) text += "\n";
    add_line([&](const TableColumn& column) { return column.cells[row]; });
  }
  return text;
}

}  // namespace

std::string text_table(const std::vector<std::vector<std::string>>& rows, const TableShape& shape) {
  Columns all(rows.at(0).size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].left = i < shape.text || (shape.last_text && i + 1 == all.size());
    all[i].title = {plain(rows[0][i])};
    for (std::size_t k = 1; k < rows.size(); ++k) all[i].cells.push_back(plain(rows[k][i]));
  }
  if (width_of(all) > shape.width) std::ranges::for_each(all, &TableColumn::break_title);
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
