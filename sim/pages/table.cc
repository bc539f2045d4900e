#include "sim/pages/table.h"

#include <fmt/core.h>

#include <limits>

#include "sim/files/csv.h"
#include "sim/files/file_error.h"
#include "sim/files/number.h"

namespace sim::pages {
namespace {

std::string column_name(std::string title) {
  if (title.starts_with('#')) title.erase(0, 1);
  return title.substr(0, title.find(" ["));
}

}  // namespace

Table::Table(const std::filesystem::path& file) : file_(file) {
  files::CsvReader csv(file);
  std::vector<std::vector<std::string>*> columns;
  for (const std::string& title : csv.titles()) {
    const auto [column, is_new] = columns_.try_emplace(column_name(title));
    if (!is_new) throw files::FileError(file_, 1, fmt::format("has the column '{}' twice", column->first));
    columns.push_back(&column->second);
  }
  for (; csv.next(); ++rows_)
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i]->emplace_back(csv.text(i));
}

const std::vector<std::string>& Table::text(std::string_view column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end()) throw files::FileError(file_, fmt::format("no column '{}'", column));
  return found->second;
}

std::vector<double> Table::numbers(std::string_view column) const {
  std::vector<double> values;
  for (const std::string& field : text(column))
    values.push_back(files::parse_number<double>(field).value_or(std::numeric_limits<double>::quiet_NaN()));
  return values;
}

std::vector<double> Table::seconds(std::string_view column) const {
  std::vector<double> values = numbers(column);
  for (double& value : values) value *= 1e-9;
  return values;
}

}  // namespace sim::pages
