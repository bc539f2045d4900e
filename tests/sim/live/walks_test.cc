// Whole walks of the shipped scenarios, without camera and filter.

#include "tests/sim/live/run_folder.h"
#include "tests/sim/scenario/test_scenarios.h"

namespace sim::live {
namespace {

namespace fs = std::filesystem;

// Without an estimate, the truth steers.
scenario::ReadScenario without_filter(const fs::path& file) {
  const auto by = scenario::read_scenario(file).scenario.walk.steering.by;
  std::vector<std::string> overrides;
  if (by == walking::SteeredBy::estimate) overrides.emplace_back("walk.steering.by=truth");
  return scenario::read_scenario(file, {overrides, {"camera", "slam"}});
}

// One scenario per walk: those that differ only in filter, camera, sensor errors or limits walk alike.
std::vector<fs::path> distinct_walks() {
  std::set<std::string> seen;
  std::vector<fs::path> files;
  for (const fs::path& file : scenario::scenario_files()) {
    const auto read = without_filter(file).scenario;
    scenario::Scenario walk;
    walk.seed = read.seed;
    walk.walk = read.walk;
    walk.stabilizer = read.stabilizer;
    walk.world = read.world;
    walk.limits.ending = read.limits.ending;
    if (seen.insert(scenario::to_yaml(walk)).second) files.push_back(file);
  }
  return files;
}

class LongWalks : public tests::RunFolder, public testing::WithParamInterface<fs::path> {};
INSTANTIATE_TEST_SUITE_P(, LongWalks, testing::ValuesIn(distinct_walks()), scenario::test_name);

// A warning of MuJoCo (a buffer too small, a bad state) ends a walk as "failed". A scenario that asks its
// filter to give up ("diverged") completes here without it.
TEST_P(LongWalks, CompleteAndRaiseNoWarning) {
  const scenario::ReadScenario walk = without_filter(GetParam());
  const result::Outcome outcome = run("walk", walk);
  const std::vector<std::string>& allowed = walk.scenario.limits.ending;
  const bool stops = allowed == std::vector<std::string>{"stopped"};
  EXPECT_EQ(outcome.ending, stops ? scenario::Ending::stopped : scenario::Ending::completed) << outcome.cause;
  if (std::ranges::count(allowed, "completed") > 0) {
    EXPECT_EQ(outcome.exit_code, 0);
  }
}

}  // namespace
}  // namespace sim::live
