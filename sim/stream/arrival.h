// The order in which observations arrive: doubled, or after the next one.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/stream/faults.h"
#include "slam/observation.h"

namespace sim::stream {

/// Draws are keyed by seed and stamp.
class Arrival {
 public:
  Arrival(std::uint64_t seed, const std::vector<Fault>& faults);

  std::vector<slam::Observation> take(slam::Observation observation);
  std::vector<slam::Observation> rest();  ///< what still waits for its turn

 private:
  bool doubled(slam::Stamp t) const;
  bool late(slam::Stamp t) const;

  std::uint64_t seed_;
  std::vector<FramesDoubled> doubled_;
  std::vector<FramesReordered> reordered_;
  std::optional<slam::Observation> late_;
};

}  // namespace sim::stream
