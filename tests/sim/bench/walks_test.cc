// Whole walks of the shipped scenarios, without camera and filter.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "sim/bench/run.h"

namespace sim::bench {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> scenarios() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(fs::path(GAITSLAM_SOURCE_DIR) / "scenarios")) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// A warning of MuJoCo (a buffer too small, a bad state) ends a walk as "failed".
TEST(Walks, OfEveryScenarioEndAsItAllowsAndRaiseNoWarning) {
  const fs::path out = fs::temp_directory_path() / ("gaitslam walks " + std::to_string(getpid()));
  fs::create_directories(out);
  for (const fs::path& file : scenarios()) {
    const ReadScenario read = read_scenario(file, {{}, {"camera", "slam"}});
    const fs::path models = fs::path(GAITSLAM_SOURCE_DIR) / "models";
    const ResultPlace place{out / file.stem(), stream::Existing::refuse, models, "1", "test", {}};
    const Outcome outcome = run(read, place, [](double) {});
    EXPECT_NE(outcome.ending, "failed") << file << ": " << outcome.cause;
    EXPECT_EQ(outcome.exit_code, 0) << file << ": " << outcome.ending << ", " << outcome.cause;
  }
  fs::remove_all(out);
}

}  // namespace
}  // namespace sim::bench
