#include "sim/regression/suite.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "sim/scenario/yaml.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::regression {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class SuiteTest : public testing::Test {
 protected:
  SuiteTest() {
    std::filesystem::create_directories(folder_ / "suites");
    std::ofstream(folder_ / "walk.yaml") << "walk: {commands: [{stand: {duration_s: 1}}]}\n";
  }
  Suite read(const std::string& text) const {
    std::ofstream(folder_ / "suites/ci.yaml") << text;
    return read_suite(folder_ / "suites/ci.yaml");
  }
  void expect_refused(const std::string& text, const std::string& why) const {
    try {
      read(text);
      ADD_FAILURE() << text;
    } catch (const scenario::ConfigError& e) {
      EXPECT_THAT(e.what(), HasSubstr(why));
      EXPECT_THAT(e.what(), HasSubstr(".yaml"));
    }
  }
  const files::TemporaryFolder folder_;
};

TEST_F(SuiteTest, TheShippedSuitesAreValid) {
  for (const char* const name : {"ci", "faults", "filter_training", "filter_test"})
    EXPECT_FALSE(
        read_suite(fmt::format(GAITSLAM_SOURCE_DIR "/scenarios/suites/{}.yaml", name)).entries.empty());
}

TEST_F(SuiteTest, HasScenariosWithChangesAndGates) {
  const Suite suite = read(R"(
seeds: 1..3
scenarios:
  - scenario: ../walk.yaml
    set: [walk.step_length_m=0.1]
    gate: {rmse_m: {percent: 10}, loop_landmarks: {percent: 5, absolute: 2}}
  - {scenario: ../walk.yaml, set: [name=other], without: [slam]}
)");
  EXPECT_EQ(suite.name, "ci");
  EXPECT_EQ(suite.seeds, "1..3");
  ASSERT_EQ(suite.entries.size(), 2u);
  EXPECT_EQ(suite.entries[0].file, folder_ / "walk.yaml");
  EXPECT_THAT(suite.entries[0].changes.overrides, ElementsAre("walk.step_length_m=0.1"));
  EXPECT_THAT(suite.entries[0].gates, ElementsAre(Gate{"rmse_m", 10, 0}, Gate{"loop_landmarks", 5, 2}));
  EXPECT_THAT(suite.entries[1].changes.without, ElementsAre("slam"));
  EXPECT_EQ(suite.entries[1].gates, default_gates());
}

TEST_F(SuiteTest, WhatIsNoSuiteIsRefused) {
  expect_refused("seeds: 1..3\nscenarios: []\n", "the suite is empty");
  expect_refused("seeds: 1..3\n", "the suite is empty");
  expect_refused("scenarios: [{scenario: ../walk.yaml}]\n", "seeds: missing");
  expect_refused("seeds: 1\nscenarios: [{scenario: ../none.yaml}]\n", "none.yaml: cannot be read");
  expect_refused("seeds: 1\nscenarios: [{set: [a=b]}]\n", "scenario: missing");
  expect_refused("seeds: 1\nscenarios: [{scenraio: x}]\n",
                 "ci.yaml:2:14: scenraio: unknown key; did you mean 'scenario'?");
  expect_refused("seed: 1\n", "did you mean 'seeds'?");
  expect_refused("[]\n", "expected a suite");
  expect_refused("seeds: 1\nscenarios: [{scenario: ../walk.yaml}, {scenario: ../walk.yaml}]\n",
                 "two scenarios are called 'walk'");
  expect_refused("seeds: 1\nscenarios: [{scenario: ../walk.yaml, set: [walk.step=1]}]\n", "unknown key");
}

TEST_F(SuiteTest, WhatIsWrongInASetOrWithoutIsSaidWithItsPlace) {
  const std::string one = "seeds: 1\nscenarios: [{scenario: ../walk.yaml, ";
  expect_refused(one + "set: [walk.step=1]}]\n", "ci.yaml:2:44: set: walk.step: unknown key");
  expect_refused(one + "set: [name=a, seed=x]}]\n", "ci.yaml:2:57: set: seed: ");
  expect_refused(one + "set: [name]}]\n", "ci.yaml:2:44: set: 'name': expected key=value");
  expect_refused(one + "set: [[name=a]]}]\n", "ci.yaml:2:44: set: expected text, as in [seed=1]");
  expect_refused(one + "set: name=a}]\n", "ci.yaml:2:43: set: expected a list, as in [seed=1]");
  expect_refused(one + "without: [slma]}]\n",
                 "ci.yaml:2:48: without: 'slma', expected camera or slam; did you mean 'slam'?");
  expect_refused(one + "without: slam}]\n", "ci.yaml:2:47: without: expected a list, as in [slam]");
}

TEST_F(SuiteTest, GatesThatAreWrongAreRefused) {
  const auto gate = [](const std::string& text) {
    return "seeds: 1\nscenarios: [{scenario: ../walk.yaml, gate: " + text + "}]\n";
  };
  expect_refused(gate("{rsme_m: {percent: 1}}"), "unknown metric 'rsme_m'; did you mean 'rmse_m'?");
  expect_refused(gate("{rmse_m: 10}"), "expected a tolerance");
  expect_refused(gate("{rmse_m: {percent: -1}}"), "gate.rmse_m.percent");
  expect_refused(gate("{rmse_m: {precent: 1}}"), "did you mean 'percent'?");
  expect_refused(gate("{}"), "has 0 metrics, expected 1 to 6");
  expect_refused(gate("{rmse_m: {}, rpe_1m_m: {}, rpe_1m_deg: {}, end_yaw_error_deg: {}, ate_se3_rmse_m: {}, "
                      "ate_yaw_rmse_m: {}, ate_sim3_rmse_m: {}}"),
                 "has 7 metrics, expected 1 to 6");
}

TEST_F(SuiteTest, AConfigurationIsWhatFileAndChangesSetNotWhatJudgesIt) {
  const auto config = [](const std::string& text, const std::vector<std::string>& overrides) {
    return config_of(scenario::read_scenario_text(text, "walk.yaml", {overrides, {}}));
  };
  const std::string walk = "seed: 5\nwalk: {step_length_m: 0.1, commands: [{stand: {duration_s: 1}}]}\n";
  const auto plain = config(walk, {});
  EXPECT_EQ(plain.at("walk.step_length_m"), "0.1");
  EXPECT_EQ(plain.size(), 2u);
  EXPECT_EQ(config(walk, {"seed=9", "limits.rmse_m.at_most=1", "name=x"}), plain);
  EXPECT_NE(config(walk, {"walk.step_length_m=0.2"}), plain);
  EXPECT_EQ(config(walk + "camera: {}\n", {}).at("camera"), "present");
}

}  // namespace
}  // namespace sim::regression
