// What the filter saw of a recorded run: its observations with the sensor errors of the scenario.
#pragma once

#include <filesystem>
#include <optional>

#include "sim/stream/recording.h"
#include "sim/stream/sensor_errors.h"

namespace sim::stream {

/// Gives what a live run or a replay gave the filter, in the same order and with the same bits. Throws as
/// RecordingReader and SensorErrors do.
class Seen {
 public:
  Seen(const std::filesystem::path& recording, const ErrorOptions& errors, std::uint64_t seed)
      : reader_(recording), errors_(errors, seed) {}

  const RecordingSetup& setup() const { return reader_.setup(); }
  std::optional<slam::Observation> next() {
    std::optional<slam::Observation> ideal = reader_.next();
    if (!ideal) return std::nullopt;
    return errors_.apply(std::move(*ideal));
  }

 private:
  RecordingReader reader_;
  SensorErrors errors_;
};

}  // namespace sim::stream
