// Errors of the planned motion on its way to the filter.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/sensor_errors/faults.h"
#include "slam/observation.h"

namespace sim::sensor_errors {

/// Takes the plans of one observation after another. velocity_sigma_m_s: white error of the planned velocity
/// along x and y of P, drawn for each frame by seed and stamp; its integral is added to the planned position.
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
  std::optional<Eigen::Vector3d> last_p_PC_;                    // as planned
  Eigen::Vector3d position_error_P_ = Eigen::Vector3d::Zero();  // accumulated so far
};

}  // namespace sim::sensor_errors
