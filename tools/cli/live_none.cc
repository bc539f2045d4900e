#include "tools/cli/commands.h"
#include "tools/cli/live.h"

namespace cli {

sim::bench::Outcome run_live(const sim::bench::ReadScenario&, const sim::bench::ResultPlace&,
                             const sim::bench::Progress&) {
  require_simulator();
  return {};
}

void require_simulator() {
  throw UsageError("run: this build has no simulator (GAITSLAM_WORLD=OFF); replay, check and config work");
}

walking::WholeBody whole_body(const sim::bench::Scenario&, const std::filesystem::path&) { return {}; }

RobotView robot_from_outside(const sim::bench::Scenario&, const std::filesystem::path&,
                             const std::filesystem::path&) {
  return {};
}

std::string mujoco_version() { return ""; }

}  // namespace cli
