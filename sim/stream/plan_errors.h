// What goes wrong with the planned motion on its way to the filter.
#pragma once

#include <optional>
#include <vector>

#include "sim/stream/faults.h"
#include "slam/observation.h"

namespace sim::stream {

/// Takes the plans of one observation after another.
class PlanErrors {
 public:
  explicit PlanErrors(const std::vector<Fault>& faults);
  std::optional<slam::PlannedMotion> apply(std::optional<slam::PlannedMotion> plan, slam::Stamp t);

 private:
  std::vector<PlanMissing> missing_;
  std::vector<PlanScaled> scaled_;
  std::optional<Eigen::Vector3d> last_p_PC_;                // as planned
  Eigen::Vector3d gone_too_far_ = Eigen::Vector3d::Zero();  // in P, by the wrong plans so far
};

}  // namespace sim::stream
