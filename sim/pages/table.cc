#include "sim/pages/table.h"

#include <algorithm>
#include <cmath>

#include "sim/files/csv.h"
#include "sim/files/text.h"

namespace sim::pages {

std::vector<std::string> names_of(std::vector<std::string> titles) {
  for (std::string& title : titles) {
    if (title.starts_with('#')) title.erase(0, 1);
    title.resize(std::min(title.size(), title.find(" [")));
  }
  return titles;
}

Table::Table(const fs::path& file) : file_(file) {
  files::CsvReader csv(file);
  std::vector<std::vector<std::string>*> columns;
  for (const std::string& name : names_of(csv.titles())) {
    const auto [column, is_new] = columns_.try_emplace(name);
    if (!is_new) throw files::FileError(file_, 1, "has a duplicate column '{}'", column->first);
    columns.push_back(&column->second);
  }
  for (; csv.next(); ++rows_)
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i]->emplace_back(csv.text(i));
}

const std::vector<std::string>& Table::text(std::string_view column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end()) throw files::FileError(file_, "has no column '{}'", column);
  return found->second;
}

Column Table::numbers(std::string_view column) const {
  Column values;
  for (const std::string& field : text(column))
    values.push_back(files::parse_number<double>(field).value_or(NAN));
  return values;
}

Column Table::seconds(std::string_view column) const {
  Column values = numbers(column);
  for (double& value : values) value *= 1e-9;
  return values;
}

std::vector<slam::Stamp> Table::stamps(std::string_view column) const {
  std::vector<slam::Stamp> all;
  for (const std::string& field : text(column)) {
    const auto ns = files::parse_number<std::int64_t>(field);
    if (!ns) throw files::FileError(file_, "'{}' is not a time stamp", field);
    all.emplace_back(*ns);
  }
  return all;
}

}  // namespace sim::pages
