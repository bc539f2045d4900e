#include "tools/cli/shared/live.h"
#include "tools/cli/shared/terminal.h"

namespace cli {

sim::result::Outcome run_live(const sim::scenario::ReadScenario&, const sim::result::ResultPlace&,
                              const sim::result::Progress&, int, const sim::live::RunObserver*) {
  require_simulator();
  return {};
}

void require_simulator() {
  throw UsageError("run: this build has no simulator (GAITSLAM_WORLD=OFF); replay, check and config work");
}

bool require_clear_walk(const sim::scenario::ReadScenario&, const std::filesystem::path&) { return false; }

walking::WholeBody whole_body(const sim::scenario::Scenario&, const std::filesystem::path&) { return {}; }

std::string mujoco_version() { return ""; }

}  // namespace cli
