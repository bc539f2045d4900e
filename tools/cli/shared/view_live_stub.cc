// Stubs for a build without the simulator: no robot commands, and a view without room and robot.
#include "sim/view/session.h"
#include "sim/view/site.h"
#include "tools/cli/commands.h"
#include "tools/cli/shared/live.h"

namespace sim::view {

MakeRobot robot_maker(const fs::path&) { return {}; }

std::shared_ptr<const exports::RobotDescription> robot_description(const scenario::Scenario&,
                                                                   const fs::path&) {
  return nullptr;
}

RobotView robot_from_outside(const scenario::Scenario&, const fs::path&, const fs::path&) { return {}; }

std::unique_ptr<ViewSession> view_of_run(const ViewRequest& request, const scenario::ReadScenario&,
                                         const fs::path&) {
  if (request.view) cli::require_simulator();
  return nullptr;
}

}  // namespace sim::view

void cli::add_robot(CLI::App&, int&) {}
void cli::add_walker(CLI::App&, int&) {}
