#include <numbers>

#include "sim/score/metric_values.h"

namespace sim::score {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// part(what the feet did in a phase), if they were watched.
template <typename Part>
Value of_feet(const Scored& s, FootPhase phase, Part part) {
  if (s.run.feet.empty()) return Value::none("the feet were not recorded");
  return part(total(s.run.feet, phase));
}

// part summed over the phases in which a foot moves on the ground.
template <typename Part>
Value on_ground(const Scored& s, Part part) {
  if (s.run.feet.empty()) return Value::none("the feet were not recorded");
  double sum = 0;
  for (FootPhase phase : {FootPhase::landing, FootPhase::support, FootPhase::lift_off})
    sum += part(total(s.run.feet, phase));
  return sum;
}

constexpr auto kMoved = [](const FootTotal& t) { return t.moved; };
constexpr auto kTurned = [](const FootTotal& t) { return t.turned / kDegree; };
constexpr auto kDriftX = [](const FootTotal& t) { return t.drift.x; };
constexpr auto kDriftY = [](const FootTotal& t) { return t.drift.y; };
constexpr auto kDriftYaw = [](const FootTotal& t) { return t.drift.yaw / kDegree; };

}  // namespace

Value foot_slip_landing(const Scored& s) { return of_feet(s, FootPhase::landing, kMoved); }
Value foot_slip_support(const Scored& s) { return of_feet(s, FootPhase::support, kMoved); }
Value foot_slip_lift_off(const Scored& s) { return of_feet(s, FootPhase::lift_off, kMoved); }
Value foot_turn_landing(const Scored& s) { return of_feet(s, FootPhase::landing, kTurned); }
Value foot_turn_support(const Scored& s) { return of_feet(s, FootPhase::support, kTurned); }
Value foot_turn_lift_off(const Scored& s) { return of_feet(s, FootPhase::lift_off, kTurned); }
Value foot_creep(const Scored& s) {
  return on_ground(s, [](const FootTotal& t) { return t.creep; });
}
Value foot_creep_turn(const Scored& s) {
  return on_ground(s, [](const FootTotal& t) { return t.creep_turn / kDegree; });
}
Value slip_drift_x(const Scored& s) { return on_ground(s, kDriftX); }
Value slip_drift_y(const Scored& s) { return on_ground(s, kDriftY); }
Value slip_drift_yaw(const Scored& s) { return on_ground(s, kDriftYaw); }
Value put_down_drift_x(const Scored& s) { return of_feet(s, FootPhase::put_down, kDriftX); }
Value put_down_drift_y(const Scored& s) { return of_feet(s, FootPhase::put_down, kDriftY); }
Value put_down_drift_yaw(const Scored& s) { return of_feet(s, FootPhase::put_down, kDriftYaw); }

}  // namespace sim::score
