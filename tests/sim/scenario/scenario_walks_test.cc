// The walk of every scenario in scenarios/ and its folders, planned.
#include "sim/scenario/scenario.h"
#include "tests/sim/scenario/scenario_files.h"
#include "tests/walking/smooth_walk.h"

namespace sim::scenario {
namespace {

class ScenarioWalk : public testing::TestWithParam<std::filesystem::path> {};
INSTANTIATE_TEST_SUITE_P(, ScenarioWalk, testing::ValuesIn(scenario_files()), test_name);

TEST_P(ScenarioWalk, IsSmooth) {
  walking::expect_smooth(walking::planned(read_scenario(GetParam()).scenario.walk));
}

}  // namespace
}  // namespace sim::scenario
