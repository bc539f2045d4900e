#include "sim/controllers/plan_controller.h"

#include <utility>

#include "walking/kinematics.h"

namespace sim::controllers {

PlanController::PlanController(walking::PatternGenerator plan, const walking::StabilizerOptions& stabilizer)
    : plan_(std::move(plan)),
      adjustment_(plan_.robot(), stabilizer.landing_adjustment),
      stabilizer_(plan_.robot(), stabilizer),
      q_(walking::inverse_kinematics(plan_.robot(), reference_, plan_.robot().posture).q),
      start_(q_) {}

JointCommands PlanController::command(const Readings& readings, bool) {
  adjusted_ = adjustment_.adjust(reference_, stabilizer_.state(), readings);
  const walking::Posture posture = stabilizer_.step(adjusted_, readings);
  const walking::JointVector q = walking::inverse_kinematics(plan_.robot(), posture, q_).q;
  return {q, (q - std::exchange(q_, q)) / walking::kPeriod};
}

void PlanController::advance() {
  reference_ = std::exchange(following_, plan_.next());
  adjusted_ = adjustment_.shifted(reference_);
  ++tick_;
}

}  // namespace sim::controllers
