#include "sim/recording/external_rows.h"

#include <fmt/format.h>

#include <stdexcept>

namespace sim::recording {

namespace fs = std::filesystem;

std::string seconds_text(slam::Stamp t) { return fmt::format("{:.3f} s", slam::seconds(t)); }

slam::Stamp Stamps::at(const files::CsvReader& row) const {
  const auto t = files::parse_stamp(row.text(field), *unit);
  if (!t || t->count() < 0) row.fail(field, "expected a stamp from 0 to 9000000000000000000 ns");
  return *t;
}

std::string Stamps::span() const {
  return fmt::format("from {} to {}", seconds_text(all.front()), seconds_text(all.back()));
}

files::Header header_of(const fs::path& file, const files::CsvReader& rows) {
  return {file, 1, rows.titles()};
}

Stamps stamps_of(const fs::path& file, std::size_t least_columns, const StatedRate& rate) {
  files::CsvReader rows(file, least_columns);
  const files::Header header = header_of(file, rows);
  Stamps stamps{header.time_field(), nullptr, {}};
  std::vector<double> numbers;
  while (rows.next()) numbers.push_back(rows.number(stamps.field));
  try {
    stamps.unit = &files::unit_of_stamps(numbers, header.time_unit(), 1 / rate.hz.value_or(20));
  } catch (const std::invalid_argument& contradiction) {
    throw files::FileError(file, contradiction.what());
  }
  for (files::CsvReader again(file, least_columns); again.next();) {
    const slam::Stamp t = stamps.at(again);
    if (!stamps.all.empty() && t <= stamps.all.back())
      again.fail(stamps.field, "the stamp is not after the one before");
    stamps.all.push_back(t);
  }
  const auto step = files::median_step(numbers);
  if (!step || !rate.hz) return stamps;
  const double hz = 1e9 / (*step * static_cast<double>(stamps.unit->ns)), ratio = *rate.hz / hz;
  if (ratio > rate.slack || ratio < 1 / 1.5)
    throw files::FileError(
        file, fmt::format("its rows come at {:.4g} Hz, its sensor.yaml states rate_hz: {}", hz, *rate.hz));
  return stamps;
}

ExternalRows::ExternalRows(const fs::path& file, std::size_t least_columns, Stamps stamps)
    : csv_(file, least_columns), header_(header_of(file, csv_)), stamps_(std::move(stamps)) {
  advance();
}

}  // namespace sim::recording
