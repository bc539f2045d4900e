#include <mujoco/mujoco.h>

#include "sim/live/robot_check.h"
#include "sim/live/run.h"
#include "sim/physics/first_robot_file.h"
#include "tools/cli/shared/live.h"

namespace cli {

result::Outcome run_live(const scenario::ReadScenario& scenario, const result::ResultPlace& place,
                         const result::Progress& progress, int threads, const live::RunObserver* observer) {
  return live::run(scenario, place, progress, threads, observer ? *observer : live::RunObserver{});
}

void require_simulator() {}

std::optional<walking::PatternGenerator> check_start(const scenario::ReadScenario& read,
                                                     const fs::path& models) {
  return live::check(read, models);
}

bool check_robot(const fs::path& folder, const std::function<void(const std::string&)>& print) {
  return live::check_robot(folder, print);
}

std::string first_robot_file(const fs::path& model, const std::string& written) {
  return physics::first_robot_file(model, written);
}

std::string mujoco_version() { return mj_versionString(); }

}  // namespace cli
