#include "sim/score/feet_metrics.h"

#include "sim/score/scored.h"

namespace sim::score {
namespace {

using Phases = std::vector<FootPhase>;
using Part = double (*)(const FootTotal&);
constexpr auto kOnGround = {FootPhase::landing, FootPhase::support, FootPhase::lift_off};

// A part of what the feet did, summed over some phases.
Value summed(const Scored& s, const Phases& phases, Part part) {
  if (s.run.feet.empty()) return Value::none("the feet were not recorded");
  double sum = 0;
  for (const FootPhase phase : phases) sum += part(total(s.run.feet, phase));
  return sum;
}

MetricDefinition metric(const std::string& name, const std::string& unit, const std::string& text,
                        const Phases& phases, Part part, Worst worst = Worst::largest) {
  return {name, unit, text, Needs::walk, [=](const Scored& s) { return summed(s, phases, part); }, worst};
}

struct Phase {
  FootPhase phase;
  const char *name, *when;
};
constexpr Phase kPhases[] = {
    {FootPhase::landing, "landing",
     "while it lands: from the first contact until it first carries 40 % of the weight"},
    {FootPhase::support, "support",
     "while it supports the robot: from when it first to when it last carries 40 % of the weight"},
    {FootPhase::lift_off, "lift_off",
     "while it lifts off: from when it last carries 40 % of the weight until it leaves the ground"}};

void add_drift(MetricDefinitions& all, const std::string& name, const Phases& phases,
               const std::string& source) {
  const std::string of = ": the share of feet " + source;
  all.push_back(metric(
      name + "_drift_x_m", "m", "Part of plan_drift_x_m" + of, phases,
      [](const FootTotal& t) { return t.drift.x; }, Worst::largest_magnitude));
  all.push_back(metric(
      name + "_drift_y_m", "m", "Part of plan_drift_y_m" + of, phases,
      [](const FootTotal& t) { return t.drift.y; }, Worst::largest_magnitude));
  all.push_back(metric(
      name + "_drift_yaw_deg", "deg", "Part of plan_drift_yaw_deg" + of, phases,
      [](const FootTotal& t) { return t.drift.yaw / kDegree; }, Worst::largest_magnitude));
}

}  // namespace

MetricDefinitions feet_metrics() {
  MetricDefinitions all;
  for (const auto& [phase, name, when] : kPhases)
    all.push_back(
        metric(std::string("slip_") + name + "_m", "m",
               std::string("Distance that the sole of a foot slips on the ground, end minus begin, ") + when +
                   "; summed over all steps.",
               {phase}, [](const FootTotal& t) { return t.moved; }));
  for (const auto& [phase, name, when] : kPhases)
    all.push_back(
        metric(std::string("slip_") + name + "_deg", "deg",
               std::string("Angle by which the sole of a foot turns on the ground, end minus begin, ") +
                   when + "; magnitudes summed over all steps.",
               {phase}, [](const FootTotal& t) { return t.turned / kDegree; }));
  all.push_back(metric("contact_creep_m", "m",
                       "Part of slip_landing_m, slip_support_m and slip_lift_off_m that happens below the "
                       "friction cone: a numerical artefact of the contact model.",
                       kOnGround, [](const FootTotal& t) { return t.creep; }));
  all.push_back(metric("contact_creep_deg", "deg",
                       "Part of slip_landing_deg, slip_support_deg and slip_lift_off_deg that happens below "
                       "the friction cone: a numerical artefact of the contact model.",
                       kOnGround, [](const FootTotal& t) { return t.creep_turn / kDegree; }));
  add_drift(all, "slip", kOnGround, "that move on the ground.");
  add_drift(all, "put_down", {FootPhase::put_down},
            "that are put down beside their planned places as seen from the other foot.");
  return all;
}

}  // namespace sim::score
