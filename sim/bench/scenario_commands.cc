#include "sim/bench/scenario_commands.h"

#include "sim/bench/kind_list.h"

namespace sim::bench {
namespace {

using walking::PerpendicularArc, walking::Stand, walking::Step, walking::Steps, walking::Straight,
    walking::TangentArc;

constexpr Domain kLength{-1000, 1000}, kDuration{0, 3600}, kRadius{0.05, 1000}, kStep{-1, 1};

template <class Kind>
Grammar<Kind> arc(std::string_view word) {
  return {word,
          {make_key<Kind>(GAITSLAM_FIELD(radius_m), kRadius, "of the circle"),
           make_angle_key<Kind>(
               "angle_deg", [](auto&& command) -> auto& { return command.angle_rad; },
               "positive: the robot turns left")}};
}

Grammar<Steps> steps() {
  return {
      "steps",
      {make_key<Step>(GAITSLAM_FIELD(forward_m), kStep,
                      "of each landing: ahead, seen from the standing foot"),
       make_key<Step>(GAITSLAM_FIELD(left_m), kStep, "to the left of it: the left foot; negative: the right"),
       make_angle_key<Step>(
           "turn_deg", [](auto&& step) -> auto& { return step.turn_rad; },
           "by which that foot's frame is turned first")}};
}

const auto& commands_list() {
  static const KindList<Stand, Straight, TangentArc, PerpendicularArc, Steps> list(
      "command", "stand: {duration_s: 1}",
      {"stand", {make_key<Stand>(GAITSLAM_FIELD(duration_s), kDuration, "time on both feet")}},
      {"straight",
       {make_key<Straight>(GAITSLAM_FIELD(forward_m), kLength, "ahead, in the robot's frame at the start"),
        make_key<Straight>(GAITSLAM_FIELD(left_m), kLength, "to the left; negative: to the right")}},
      arc<TangentArc>("tangent_arc"), arc<PerpendicularArc>("perpendicular_arc"), steps());
  return list;
}

}  // namespace

void read_commands(const Yaml& node, std::string_view key, std::vector<walking::Command>& commands) {
  if (node.kind == Yaml::Kind::list && !node.items.empty()) return commands_list().read(node, key, commands);
  fail(node, key, "expected a list of commands, as in [{stand: {duration_s: 1}}]");
}

std::string print_commands(const std::vector<walking::Command>& commands) {
  return commands_list().print(commands);
}

std::string describe_commands() { return commands_list().describe(); }

}  // namespace sim::bench
