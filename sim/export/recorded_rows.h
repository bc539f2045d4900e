// Rows of a recording that nothing but other programs reads, merged with the observations by time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/recording/recording_format.h"

namespace sim::exports {

/// The rows of mav0/<sensor>/data.csv; none where the recording has no such file. All members throw
/// FileError.
class RecordedRows {
 public:
  RecordedRows(const std::filesystem::path& recording, const std::string& sensor);

  /// The titles of the columns without their units, the stamp's left out.
  const std::vector<std::string>& names() const { return names_; }
  /// A row: its stamp, and what is behind it.
  struct Row {
    slam::Stamp t{0};
    std::vector<double> values;
  };
  /// The last row until then, unless an earlier call has given it.
  std::optional<Row> latest(slam::Stamp until);

 private:
  std::optional<recording::StampedRows> rows_;
  std::vector<std::string> names_;
};

}  // namespace sim::exports
