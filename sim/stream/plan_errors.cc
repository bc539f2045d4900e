#include "sim/stream/plan_errors.h"

#include <algorithm>

namespace sim::stream {

PlanErrors::PlanErrors(const std::vector<Fault>& faults)
    : missing_(faults_of<PlanMissing>(faults)), scaled_(faults_of<PlanScaled>(faults)) {}

std::optional<slam::PlannedMotion> PlanErrors::apply(std::optional<slam::PlannedMotion> plan, slam::Stamp t) {
  if (!plan) return plan;
  double factor = 1;
  for (const PlanScaled& scaled : scaled_)
    if (scaled.holds(t)) factor *= scaled.factor;
  const Eigen::Vector3d p_PC = plan->X_PC.translation();
  gone_too_far_ += (factor - 1) * (p_PC - last_p_PC_.value_or(p_PC));
  last_p_PC_ = p_PC;
  plan->X_PC.translation() += gone_too_far_;
  plan->v_PC_C *= factor;
  if (std::any_of(missing_.begin(), missing_.end(), [t](const PlanMissing& m) { return m.holds(t); }))
    plan.reset();
  return plan;
}

}  // namespace sim::stream
