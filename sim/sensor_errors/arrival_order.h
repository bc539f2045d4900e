// The order in which observations arrive: some twice, some after the next one.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/sensor_errors/faults.h"
#include "slam/observation.h"

namespace sim::sensor_errors {

/// Random draws are keyed by seed and stamp.
class ArrivalOrder {
 public:
  ArrivalOrder(std::uint64_t seed, const std::vector<Fault>& faults);

  /// What arrives once this observation has been made, in order.
  std::vector<slam::Observation> take(slam::Observation observation);
  std::vector<slam::Observation> flush();  ///< what has not arrived when the run ends

 private:
  bool doubled(slam::Stamp t) const;
  bool late(slam::Stamp t) const;

  std::uint64_t seed_;
  std::vector<FramesDoubled> doubled_;
  std::vector<FramesReordered> reordered_;
  std::optional<slam::Observation> late_;
};

}  // namespace sim::sensor_errors
