#include "sim/live/room_check.h"

#include <fmt/format.h>

#include <variant>

#include "sim/live/recorded.h"
#include "sim/physics/clearance.h"
#include "sim/physics/nominal_body.h"
#include "sim/result/limits.h"

namespace sim::live {
namespace {

/// Origin of the command; scenarios that were not read from text only have a name.
scenario::Yaml place_of(const scenario::ReadScenario& read, std::size_t command) {
  scenario::Yaml at;
  at.origin.file = read.scenario.name;
  if (command < read.command_origins.size()) at.origin = read.command_origins[command];
  return at;
}

}  // namespace

walking::PatternGenerator clear_plan(const scenario::ReadScenario& read, const physics::Models& models) {
  const scenario::Scenario& s = read.scenario;
  walking::PatternGenerator plan(s.walk, physics::nominal_body(copy_of(models.on_floor)));
  if (result::is_allowed(s, ending(physics::Condition::collided))) return plan;
  const auto found = physics::first_collision(plan, copy_of(models.in_room));
  if (!found) return plan;
  const auto command = static_cast<std::size_t>(found->command);
  const auto word = std::visit([](const auto& c) { return c.kName; }, s.walk.commands[command]);
  const Eigen::Vector3d& p = found->p_W;
  fail(place_of(read, command), fmt::format("walk.commands[{}]: {}", command, word),
       fmt::format(
           "at {:.2f} s the planned {} is within {} m of {}, at ({:.2f}, {:.2f}, {:.2f}) m in world.room "
           "{}; expected a walk clear of it, or limits.ending with collided",
           found->t_s, found->link, physics::kPlannedMargin_m, found->object, p.x(), p.y(), p.z(),
           s.world.room));
}

void require_clear_walk(const scenario::ReadScenario& read, const std::filesystem::path& models) {
  clear_plan(read, {read.scenario.world.robot, read.scenario.world.room, models});
}

}  // namespace sim::live
