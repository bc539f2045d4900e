#include "sim/sensor_errors/plan_errors.h"

#include <algorithm>

#include "sim/sensor_errors/random.h"

namespace sim::sensor_errors {

PlanErrors::PlanErrors(double velocity_sigma_m_s, std::uint64_t seed, const std::vector<Fault>& faults)
    : velocity_sigma_m_s_(velocity_sigma_m_s),
      seed_(seed),
      missing_(faults_of<PlanMissing>(faults)),
      scaled_(faults_of<PlanScaled>(faults)) {}

Eigen::Vector3d PlanErrors::velocity_error(slam::Stamp t) const {
  Random random(seed_, "plan velocity", static_cast<std::uint64_t>(t.count()));
  const double x = random.normal(), y = random.normal();
  return velocity_sigma_m_s_ * Eigen::Vector3d(x, y, 0);
}

std::optional<slam::PlannedMotion> PlanErrors::apply(std::optional<slam::PlannedMotion> plan, slam::Stamp t) {
  if (!plan) return plan;
  double factor = 1;
  for (const PlanScaled& scaled : scaled_)
    if (scaled.holds(t)) factor *= scaled.factor;
  const Eigen::Vector3d p_PC = plan->X_PC.translation();
  position_error_P_ += (factor - 1) * (p_PC - last_p_PC_.value_or(p_PC));
  last_p_PC_ = p_PC;
  if (velocity_sigma_m_s_ > 0) {
    const Eigen::Vector3d v_P = velocity_error(t);
    position_error_P_ += v_P * slam::seconds(t - last_.value_or(t));
    plan->v_PC_C += plan->X_PC.linear().transpose() * v_P;
  }
  last_ = t;
  plan->X_PC.translation() += position_error_P_;
  plan->v_PC_C *= factor;
  if (std::any_of(missing_.begin(), missing_.end(), [t](const PlanMissing& m) { return m.holds(t); }))
    plan.reset();
  return plan;
}

}  // namespace sim::sensor_errors
