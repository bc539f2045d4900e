// The view in a build without the simulator: of replays and results alone, without room and robot.
#include "tools/cli/live.h"
#include "tools/cli/robot_model.h"
#include "tools/cli/view_session.h"

namespace cli {

sim::view::MakeRobot robot_maker(const std::filesystem::path&) { return {}; }
std::shared_ptr<const sim::exports::RobotDescription> robot_description(const sim::scenario::Scenario&,
                                                                        const std::filesystem::path&) {
  return nullptr;
}

std::unique_ptr<ViewSession> view_of_run(const ViewRequest&, const sim::scenario::ReadScenario&,
                                         const std::filesystem::path&) {
  require_simulator();
  return nullptr;
}

}  // namespace cli
