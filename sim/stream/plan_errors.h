// What goes wrong with the planned motion on its way to the filter.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/stream/faults.h"
#include "slam/observation.h"

namespace sim::stream {

/// Takes the plans of one observation after another. velocity_sigma_m_s: white error of the planned velocity
/// along x and y of P, drawn for each frame by seed and stamp; the planned position goes astray with it.
class PlanErrors {
 public:
  PlanErrors(double velocity_sigma_m_s, std::uint64_t seed, const std::vector<Fault>& faults);
  std::optional<slam::PlannedMotion> apply(std::optional<slam::PlannedMotion> plan, slam::Stamp t);

 private:
  Eigen::Vector3d velocity_error(slam::Stamp t) const;

  double velocity_sigma_m_s_;
  std::uint64_t seed_;
  std::optional<slam::Stamp> last_;
  std::vector<PlanMissing> missing_;
  std::vector<PlanScaled> scaled_;
  std::optional<Eigen::Vector3d> last_p_PC_;                // as planned
  Eigen::Vector3d gone_too_far_ = Eigen::Vector3d::Zero();  // in P, by the wrong plans so far
};

}  // namespace sim::stream
