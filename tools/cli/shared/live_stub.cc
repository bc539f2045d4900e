#include "tools/cli/shared/live.h"

namespace cli {

result::Outcome run_live(const scenario::ReadScenario&, const result::ResultPlace&, const result::Progress&,
                         int, const live::RunObserver*) {
  require_simulator();
  return {};
}

void require_simulator() {
  throw UsageError("run: this build has no simulator (GAITSLAM_WORLD=OFF); replay, check and config work");
}

bool require_clear_walk(const scenario::ReadScenario&, const fs::path&) { return false; }

walking::WholeBody whole_body(const scenario::Scenario&, const fs::path&) { return {}; }

std::string mujoco_version() { return ""; }

}  // namespace cli
