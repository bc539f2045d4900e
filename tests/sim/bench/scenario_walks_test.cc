// The walk of every scenario in scenarios/, planned.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "sim/bench/scenario.h"
#include "tests/walking/smooth_walk.h"

namespace sim::bench {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> scenarios() {
  std::vector<fs::path> files;
  for (const fs::path& file : fs::directory_iterator(fs::path(GAITSLAM_SOURCE_DIR) / "scenarios"))
    if (file.extension() == ".yaml") files.push_back(file);
  std::sort(files.begin(), files.end());
  return files;
}

class ScenarioWalk : public testing::TestWithParam<fs::path> {};
INSTANTIATE_TEST_SUITE_P(, ScenarioWalk, testing::ValuesIn(scenarios()),
                         [](const auto& test) { return test.param.stem().string(); });

TEST_P(ScenarioWalk, IsSmooth) {
  walking::expect_smooth(walking::planned(read_scenario(GetParam()).scenario.walk));
}

}  // namespace
}  // namespace sim::bench
