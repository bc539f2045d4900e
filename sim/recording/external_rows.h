// Rows of csv files that other programs recorded, with stamps in the unit that all of them have.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/files/columns.h"
#include "sim/files/csv.h"
#include "slam/observation.h"

namespace sim::recording {

/// "1403715273.262 s"
std::string seconds_text(slam::Stamp t);

/// The stamps of a whole file, and how they are written.
struct Stamps {
  std::size_t field = 0;
  const files::TimeUnit* unit = &files::kNanoseconds;
  std::vector<slam::Stamp> all;

  /// The stamp of a row. Throws FileError.
  slam::Stamp at(const files::CsvReader& row) const;
  std::string span() const;  ///< "from 1.000 s to 2.000 s"; there must be stamps
};

files::Header header_of(const std::filesystem::path& file, const files::CsvReader& rows);

/// The rate that a sensor.yaml states, and how many times as high as that of the rows it may be: cameras skip
/// frames.
struct StatedRate {
  std::optional<double> hz;
  double slack = 1;
};

/// Reads all stamps and decides their unit. Throws FileError if they do not rise or have another rate.
Stamps stamps_of(const std::filesystem::path& file, std::size_t least_columns, const StatedRate& rate = {});

/// The rows of a file with their stamps, one after another. Throws FileError.
class ExternalRows {
 public:
  ExternalRows(const std::filesystem::path& file, std::size_t least_columns, Stamps stamps);
  const std::optional<slam::Stamp>& stamp() const { return stamp_; }  ///< nothing after the last row
  const files::CsvReader& row() const { return csv_; }
  const files::Header& header() const { return header_; }
  void advance() { stamp_ = csv_.next() ? std::optional(stamps_.at(csv_)) : std::nullopt; }

 private:
  files::CsvReader csv_;
  files::Header header_;
  Stamps stamps_;
  std::optional<slam::Stamp> stamp_;
};

}  // namespace sim::recording
