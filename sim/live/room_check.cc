#include "sim/live/room_check.h"

#include <fmt/format.h>

#include <variant>

#include "sim/live/recorded.h"
#include "sim/physics/clearance.h"
#include "sim/physics/nominal_body.h"
#include "sim/result/limits.h"

namespace sim::live {
namespace {

/// Where the command was written; scenarios that were not read from text have a name alone.
scenario::Yaml place_of(const scenario::ReadScenario& read, std::size_t command) {
  scenario::Yaml at;
  at.origin.file = read.scenario.name;
  if (command < read.command_origins.size()) at.origin = read.command_origins[command];
  return at;
}

}  // namespace

void require_clear_walk(const scenario::ReadScenario& read, const std::filesystem::path& models) {
  const scenario::Scenario& s = read.scenario;
  if (result::is_allowed(s, ending(physics::Condition::collided))) return;
  walking::PatternGenerator plan(s.walk, physics::nominal_body(s.world.robot, models));
  const auto found = physics::first_collision(std::move(plan), s.world, models);
  if (!found) return;
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

}  // namespace sim::live
