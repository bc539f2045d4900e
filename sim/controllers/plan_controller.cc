#include "sim/controllers/plan_controller.h"

#include <fmt/format.h>

#include <utility>

namespace sim::controllers {

PlanController::PlanController(walking::PatternGenerator plan, const walking::StabilizerOptions& stabilizer,
                               const walking::SteeringOptions& steering)
    : plan_(std::move(plan)),
      adjustment_(plan_.robot(), stabilizer.landing_adjustment),
      stabilizer_(plan_.robot(), stabilizer),
      q_(walking::inverse_kinematics(plan_.robot(), reference_, plan_.robot().posture).q),
      start_(q_) {
  if (steering.by != walking::SteeredBy::plan)
    steered_.emplace(
        Steered{walking::Steering(steering, plan_), steering.lost_s, plan_, {reference_, following_}});
}

JointCommands PlanController::command(const Readings& readings, bool) {
  const Clock::time_point begun = Clock::now();
  adjusted_ = adjustment_.adjust(reference_, stabilizer_.state(), readings);
  walking::Posture posture = stabilizer_.step(adjusted_, readings);
  if (slope_) {
    slope_->update(adjusted_, stabilizer_.state().tilt, readings);
    posture = slope_->adapted(posture);
  }
  const walking::JointVector q = walking::inverse_kinematics(plan_.robot(), posture, q_).q;
  took(Clock::now() - begun);
  return {q, (q - std::exchange(q_, q)) / walking::kPeriod};
}

void PlanController::advance() {
  reference_ = std::exchange(following_, plan_.next());
  adjusted_ = adjustment_.shifted(reference_);
  ++tick_;
  if (!steered_) return;
  auto& [now, next] = steered_->ticks;
  now = std::exchange(next, steered_->path.next());
}

std::optional<Ticks> PlanController::path() const {
  return steered_ ? std::optional(steered_->ticks) : std::nullopt;
}

std::optional<std::vector<walking::StepCorrection>> PlanController::corrections() const {
  return steered_ ? std::optional(steered_->by.corrections()) : std::nullopt;
}

std::optional<std::string> PlanController::stopped() const {
  if (!steered_ || !steered_->by.stopped_s()) return std::nullopt;
  return fmt::format("steering had no estimate for {} s at t = {:.2f} s: the robot stopped on both feet",
                     steered_->lost_s, *steered_->by.stopped_s());
}

}  // namespace sim::controllers
