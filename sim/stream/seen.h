// What the filter saw of a recorded run: its observations with the sensor errors of the scenario.
#pragma once

#include <deque>
#include <filesystem>
#include <optional>
#include <utility>

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
    while (arrived_.empty() && !ended_) {
      std::optional<slam::Observation> ideal = reader_.next();
      ended_ = !ideal;
      for (slam::Observation& o : ideal ? errors_.take(std::move(*ideal)) : errors_.rest())
        arrived_.push_back(std::move(o));
    }
    if (arrived_.empty()) return std::nullopt;
    slam::Observation next = std::move(arrived_.front());
    arrived_.pop_front();
    return next;
  }

  /// next(), without frames that go back in time or stand still in it: those the filter refuses.
  std::optional<slam::Observation> next_in_order() {
    std::optional<slam::Observation> seen = next();
    while (seen && last_ && seen->t <= *last_) seen = next();
    if (seen) last_ = seen->t;
    return seen;
  }

 private:
  RecordingReader reader_;
  SensorErrors errors_;
  std::deque<slam::Observation> arrived_;
  bool ended_ = false;
  std::optional<slam::Stamp> last_;
};

}  // namespace sim::stream
