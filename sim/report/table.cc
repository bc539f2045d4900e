#include "sim/report/table.h"

#include <fmt/core.h>

#include <charconv>
#include <fstream>
#include <limits>

#include "sim/stream/file_error.h"

namespace sim::report {
namespace {

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> all{""};
  for (const char c : line) {
    if (c == ',')
      all.emplace_back();
    else
      all.back() += c;
  }
  return all;
}

std::string column_name(std::string title) {
  if (title.starts_with('#')) title.erase(0, 1);
  return title.substr(0, title.find(" ["));
}

double number(const std::string& field) {
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  const bool whole = error == std::errc() && end == field.data() + field.size();
  return whole ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Table::Table(const std::filesystem::path& file) : file_(file) {
  std::ifstream in(file);
  std::string line;
  if (!in || !std::getline(in, line)) throw stream::FileError(file, "cannot be read or is empty");
  std::vector<std::vector<std::string>*> columns;
  for (const std::string& title : fields(line)) columns.push_back(&columns_[column_name(title)]);
  while (std::getline(in, line)) {
    std::vector<std::string> row = fields(line);
    if (row.size() != columns.size()) {
      throw stream::FileError(file, fmt::format("row {} has {} fields, the header has {}", rows_ + 1,
                                                row.size(), columns.size()));
    }
    for (std::size_t i = 0; i < row.size(); ++i) columns[i]->push_back(std::move(row[i]));
    ++rows_;
  }
}

const std::vector<std::string>& Table::text(std::string_view column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end()) throw stream::FileError(file_, fmt::format("no column '{}'", column));
  return found->second;
}

std::vector<double> Table::numbers(std::string_view column) const {
  std::vector<double> values;
  for (const std::string& field : text(column)) values.push_back(number(field));
  return values;
}

std::vector<double> Table::seconds(std::string_view column) const {
  std::vector<double> values = numbers(column);
  for (double& value : values) value *= 1e-9;
  return values;
}

}  // namespace sim::report
