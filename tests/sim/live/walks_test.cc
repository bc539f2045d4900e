// Whole walks of the shipped scenarios, without camera and filter.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "sim/live/recorded.h"
#include "sim/live/run.h"
#include "tests/sim/physics/test_worlds.h"
#include "tests/sim/scenario/scenario_files.h"

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

class LongWalks : public testing::TestWithParam<fs::path> {};
INSTANTIATE_TEST_SUITE_P(, LongWalks, testing::ValuesIn(distinct_walks()), scenario::test_name);

// A warning of MuJoCo (a buffer too small, a bad state) ends a walk as "failed". A scenario that asks its
// filter to give up ("diverged") completes here without it.
TEST_P(LongWalks, CompleteAndRaiseNoWarning) {
  const fs::path out = fs::temp_directory_path() / ("gaitslam walks " + std::to_string(getpid()));
  fs::create_directories(out);
  const scenario::ReadScenario read = without_filter(GetParam());
  const result::ResultPlace place{out / "walk", files::Existing::reject, physics::models(), "1", "test", {}};
  const result::Outcome outcome = run(read, place, [](double) {});
  const bool stops = read.scenario.limits.ending == std::vector<std::string>{"stopped"};
  EXPECT_EQ(outcome.ending, stops ? scenario::Ending::stopped : scenario::Ending::completed) << outcome.cause;
  if (const auto& allowed = read.scenario.limits.ending; std::ranges::count(allowed, "completed") > 0) {
    EXPECT_EQ(outcome.exit_code, 0);
  }
  fs::remove_all(out);
}

class LongWalksFarAway : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, LongWalksFarAway,
                         testing::Values("tangent_quadrant", "tangent_circle", "perpendicular_circle_trial1",
                                         "perpendicular_circle", "straight_10m"),
                         [](const auto& test) { return test.param; });

TEST_P(LongWalksFarAway, DriftAsTheyDoAtTheOrigin) {
  // Even: the floor's waves belong to the place.
  const fs::path file = scenario::scenario_folder() / (std::string(GetParam()) + ".yaml");
  const scenario::Scenario s =
      scenario::read_scenario(file, {{"world.variation.floor_height_m=0"}, {"camera", "slam"}}).scenario;
  const physics::PlantVariation drawn = plant_variation(s.seed, s.world);
  const physics::Walked here = physics::walk(s.walk, s.stabilizer, s.world, drawn);
  const physics::Walked there = physics::walk(s.walk, s.stabilizer, s.world, drawn, physics::far_away());
  ASSERT_EQ(there.status.condition, physics::Condition::ok) << there.status.cause;
  // Twice what ten seeds showed: rounding differs, and what slips at the limit of friction enlarges it.
  EXPECT_LT((here.X_PB.translation() - there.X_PB.translation()).norm(), 0.006);
  EXPECT_LT(Eigen::AngleAxisd(here.X_PB.linear().transpose() * there.X_PB.linear()).angle(), 0.004);
}

}  // namespace
}  // namespace sim::live
