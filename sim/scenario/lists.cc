#include "sim/scenario/lists.h"

namespace sim::scenario {

const KindList<walking::Command>& grammar_of(const std::vector<walking::Command>&) {
  static const KindList<walking::Command> list("command", "stand: {duration_s: 1}", 1);
  return list;
}
const KindList<sensor_errors::Fault>& grammar_of(const std::vector<sensor_errors::Fault>&) {
  static const KindList<sensor_errors::Fault> list("fault", "frames_lost: {from_s: 20, duration_s: 2}");
  return list;
}
const KindList<physics::Push>& grammar_of(const std::vector<physics::Push>&) {
  static const KindList<physics::Push> list("disturbance",
                                          "push: {time_s: 4, impulse_ns: 10, direction_deg: 90}");
  return list;
}
const KindList<physics::FloorPatch>& grammar_of(const std::vector<physics::FloorPatch>&) {
  static const KindList<physics::FloorPatch> list(
      "disturbance", "patch: {x_min_m: 1, x_max_m: 2, y_min_m: -1, y_max_m: 1, friction: 0.1}");
  return list;
}

std::string describe_commands() { return grammar_of(std::vector<walking::Command>()).describe(); }
std::string describe_faults() { return grammar_of(std::vector<sensor_errors::Fault>()).describe(); }
std::string describe_disturbances() {
  return grammar_of(std::vector<physics::Push>()).describe() +
         grammar_of(std::vector<physics::FloorPatch>()).describe();
}

}  // namespace sim::scenario
