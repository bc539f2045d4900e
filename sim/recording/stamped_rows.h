// A csv file whose first column is a stamp, read row by row.
#pragma once

#include <optional>

#include "sim/files/csv.h"
#include "slam/observation.h"

namespace sim::recording {

/// Always holds one row, read ahead. Stamps in the file are from 0 to 9e18 ns and rise from row to row. All
/// members throw FileError.
class StampedRows {
 public:
  /// epoch: how much later the stamps in the file are than those that stamp() gives.
  explicit StampedRows(files::CsvReader csv, slam::Stamp epoch = slam::Stamp{0});
  StampedRows(const StampedRows&) = delete;
  StampedRows& operator=(const StampedRows&) = delete;

  /// Stamp of the row at hand; nothing after the last.
  std::optional<slam::Stamp> stamp() const { return stamp_; }
  const files::CsvReader& row() const { return csv_; }
  void advance();

 private:
  files::CsvReader csv_;
  slam::Stamp epoch_;
  std::optional<slam::Stamp> stamp_;
};

}  // namespace sim::recording
