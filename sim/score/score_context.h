// A run with the quantities that several metrics need, computed once.
#pragma once

#include <optional>
#include <vector>

#include "sim/score/run.h"
#include "sim/score/statistics.h"

namespace sim::score {

/// A run from the first planned motion on. The run must outlive it.
struct ScoreContext {
  explicit ScoreContext(const Run& run);

  const Run& run;
  std::optional<Stamp> start;         ///< the first frame with a planned waist more than 1 mm from its start;
                                      ///< without a planned waist the first frame with truth
  Trajectory truth_camera, estimate;  ///< from then on
  std::vector<PosePair> pairs;        ///< of these two
  OrAbsent<std::vector<PoseNees>> nees;      ///< of the pairs with a covariance
  std::optional<Absent> no_estimate;         ///< why the estimate cannot be scored, if it cannot
  OrAbsent<std::vector<LoopLandmark>> loop;  ///< early landmarks that were found again
};

}  // namespace sim::score
