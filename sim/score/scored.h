// A run with the quantities that several metrics need, computed once.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/score/run.h"

namespace sim::score {

/// A run from the first planned motion on. The run must outlive it.
struct Scored {
  explicit Scored(const Run& run);

  const Run& run;
  std::optional<Stamp> begin;  ///< the first frame in which the planned waist is more than 1 mm from its
                               ///< start; without a planned waist the first frame with truth
  Trajectory truth_camera, estimate;  ///< from then on
  std::vector<PosePair> pairs;        ///< of these two
  std::vector<PoseNees> nees;         ///< of the pairs; shorter if one of them has none
  std::string no_nees;                ///< why one has none; empty if all have
  std::string no_estimate;            ///< why nothing can be said of the estimate; empty if something can
  std::vector<LoopLandmark> loop;     ///< the early landmarks that were found again
  std::string no_loop;                ///< why there can be none; empty if there can
};

}  // namespace sim::score
