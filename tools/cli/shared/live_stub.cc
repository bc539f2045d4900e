#include "tools/cli/shared/live.h"

namespace cli {

result::Outcome run_live(const scenario::ReadScenario&, const result::ResultPlace&, const result::Progress&,
                         int, const live::RunObserver*) {
  require_simulator();
  return {};
}

void require_simulator() {
  throw UsageError("run: this build has no simulator (GAITSLAM_WORLD=OFF), expected replay, check or config");
}

std::optional<walking::PatternGenerator> check_start(const scenario::ReadScenario&, const fs::path&) {
  return std::nullopt;
}

std::string mujoco_version() { return ""; }

}  // namespace cli
