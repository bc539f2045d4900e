// Input of the filter from a recorded run: its observations with the sensor errors of the scenario.
#pragma once

#include "sim/recording/recording.h"
#include "sim/sensor_errors/sensor_errors.h"

namespace sim::recording {

/// The observations that a live run or a replay gives the filter, bit for bit. Throws as RecordingReader and
/// SensorErrors do.
class FilterInput {
 public:
  FilterInput(const std::filesystem::path& recording, const sensor_errors::ErrorOptions& errors,
              std::uint64_t seed)
      : reader_(recording), errors_(errors, seed, reader_.setup().rig) {}

  const RecordingSetup& setup() const { return reader_.setup(); }
  /// Returns the next observation in the order of arrival, or nothing after the last.
  std::optional<slam::Observation> next();
  /// Returns next() without observations that the filter rejects because their stamps do not rise.
  std::optional<slam::Observation> next_in_order();
  /// Returns the progress of reading, 0 to 1.
  double part() const { return reader_.part(); }

 private:
  RecordingReader reader_;
  sensor_errors::SensorErrors errors_;
  std::deque<slam::Observation> arrived_;
  bool ended_ = false;
  std::optional<slam::Stamp> last_;
};

}  // namespace sim::recording
