#include "sim/regression/suite.h"

#include <fstream>

#include "tests/sim/files/temporary_folder.h"

namespace sim::regression {
namespace {

using testing::ElementsAre, testing::HasSubstr, testing::IsEmpty;

class SuiteTest : public testing::Test {
 protected:
  SuiteTest() {
    fs::create_directories(folder_ / "suites");
    std::ofstream(folder_ / "walk.yaml") << "walk: {commands: [{stand: {duration_s: 1}}]}\n";
  }
  Suite read(const std::string& text) const {
    std::ofstream(folder_ / "suites/ci.yaml") << text;
    return read_suite(folder_ / "suites/ci.yaml");
  }
  const files::TemporaryFolder folder_;
};

TEST_F(SuiteTest, TheShippedSuitesAreValid) {
  for (const char* const name : {"ci", "faults", "filter_training", "filter_test", "time"})
    EXPECT_FALSE(
        read_suite(fmt::format(GAITSLAM_SOURCE_DIR "/scenarios/suites/{}.yaml", name)).entries.empty());
}

TEST_F(SuiteTest, HasScenariosWithChangesAndGates) {
  const Suite suite = read(R"(
seeds: 1..3
consistent: 1.5
scenarios:
  - scenario: ../walk.yaml
    set: [walk.step_length_m=0.1]
    gate: {rmse_m: {percent: 10}, loop_landmarks: {percent: 5, absolute: 2}}
  - {scenario: ../walk.yaml, set: [name=other], without: [slam], expect: limits_missed}
)");
  EXPECT_EQ(suite.name, "ci");
  EXPECT_EQ(suite.seeds, "1..3");
  EXPECT_EQ(suite.consistent, 1.5);
  ASSERT_EQ(suite.entries.size(), 2u);
  EXPECT_EQ(suite.entries[0].file, folder_ / "walk.yaml");
  EXPECT_THAT(suite.entries[0].changes.overrides, ElementsAre("walk.step_length_m=0.1"));
  EXPECT_THAT(suite.entries[0].gates, ElementsAre(Gate{"rmse_m", 10, 0}, Gate{"loop_landmarks", 5, 2}));
  EXPECT_THAT(suite.entries[1].changes.without, ElementsAre("slam"));
  EXPECT_EQ(suite.entries[1].gates, default_gates());
  EXPECT_TRUE(!suite.entries[0].expects_missed && suite.entries[1].expects_missed);
}

TEST_F(SuiteTest, ErrorsAreReportedWithTheirPlace) {
  const std::string one = "seeds: 1\nscenarios: [{scenario: ../walk.yaml, ", gate = one + "gate: ";
  for (const auto& [text, why] : std::vector<std::pair<std::string, std::string>>{
           {"seeds: 1..3\nscenarios: []\n", "the suite is empty"},
           {"seeds: 1..3\n", "the suite is empty"},
           {"scenarios: [{scenario: ../walk.yaml}]\n", "seeds: missing"},
           {"seeds: 1\nscenarios: [{scenario: ../none.yaml}]\n", "none.yaml: cannot be read"},
           {"seeds: 1\nscenarios: [{set: [a=b]}]\n", "scenario: missing"},
           {"seeds: 1\nscenarios: [{scenraio: x}]\n",
            "ci.yaml:2:14: scenraio: unknown key; did you mean 'scenario'?"},
           {"seed: 1\n", "did you mean 'seeds'?"},
           {"consistent: 0.5\n", "ci.yaml:1:13: consistent: "},
           {one + "gate: {rmse_m: {relative: 1}}}]\n",
            ": relative: unknown key, expected one of percent, absolute"},
           {"[]\n", "expected a suite"},
           {"seeds: 1\nscenarios: [{scenario: ../walk.yaml}, {scenario: ../walk.yaml}]\n",
            "two scenarios are called 'walk'"},
           {one + "expect: passed}]\n", "expect: 'passed', expected limits_missed"},
           {one + "set: [walk.step=1]}]\n", "ci.yaml:2:44: set: walk.step: unknown key"},
           {one + "set: [name=a, seed=x]}]\n", "ci.yaml:2:57: set: seed: "},
           {one + "set: [name]}]\n", "ci.yaml:2:44: set: 'name': expected key=value"},
           {one + "set: [[name=a]]}]\n", "ci.yaml:2:44: set: expected text, as in [seed=1]"},
           {one + "set: name=a}]\n", "ci.yaml:2:43: set: expected a list, as in [seed=1]"},
           {one + "without: [slma]}]\n",
            "ci.yaml:2:48: without: 'slma', expected camera or slam; did you mean 'slam'?"},
           {one + "without: slam}]\n", "ci.yaml:2:47: without: expected a list, as in [slam]"},
           {gate + "{rsme_m: {percent: 1}}}]\n", "unknown metric 'rsme_m'; did you mean 'rmse_m'?"},
           {gate + "{rmse_m: 10}}]\n", "expected a tolerance"},
           {gate + "{rmse_m: {percent: -1}}}]\n", "gate.rmse_m.percent"},
           {gate + "{rmse_m: {precent: 1}}}]\n", "did you mean 'percent'?"},
           {gate + "{}}]\n", "has 0 metrics, expected 1 to 6"},
           {gate + "{rmse_m: {}, rpe_1m_m: {}, rpe_1m_deg: {}, end_yaw_error_deg: {}, ate_se3_rmse_m: {}, "
                   "ate_yaw_rmse_m: {}, ate_sim3_rmse_m: {}}}]\n",
            "has 7 metrics, expected 1 to 6"}})
    EXPECT_THAT(files::error_of([&, suite = text] { read(suite); }), tests::Has(".yaml", why)) << text;
}

TEST_F(SuiteTest, AConfigurationIsSetByFileAndChangesNotByWhatJudgesIt) {
  const auto config = [](const std::string& text, const std::vector<std::string>& overrides) {
    return config_of(scenario::read_scenario_text(text, "walk.yaml", {overrides, {}}));
  };
  const std::string walk = "seed: 5\nwalk: {step_length_m: 0.1, commands: [{stand: {duration_s: 1}}]}\n";
  const auto plain = config(walk, {});
  EXPECT_EQ(plain.at("walk.step_length_m"), "0.1");
  EXPECT_EQ(plain.at("world.floor_friction"), "0.15") << "from the robot's file";
  EXPECT_FALSE(plain.contains("seed") || plain.contains("slam.vision.sigma_px"));
  EXPECT_EQ(config(walk, {"seed=9", "limits.rmse_m.at_most=1", "name=x"}), plain);
  EXPECT_NE(config(walk, {"walk.step_length_m=0.2"}), plain);
  EXPECT_EQ(config(walk + "camera: {}\n", {}).at("camera"), "present");
}

Baseline example() {
  Baseline baseline;
  baseline.history = {{"abc", "a \"first\" one", "some processor"}, {"def", "better", "another"}};
  ScenarioResults walk{"walk", {{"walk.step_length_m", "0.1"}, {"walk.commands", "\n  - stand: {}"}}, {}};
  walk.seeds.push_back(
      {1, scenario::Ending::completed, 0, {{"rmse_m", "m", 0.1}, {"loop_closed", "1", {}}}, "aa"});
  walk.seeds.push_back(
      {7, scenario::Ending::fell, 3, {{"rmse_m", "m", 1.0 / 3}, {"loop_closed", "1", 1.0}}, "bb"});
  baseline.scenarios.push_back(walk);
  return baseline;
}

TEST(Baseline, IsReadBackBitForBit) {
  const files::TemporaryFolder folder;
  const auto file = folder / "ci.json";
  write_baseline(file, example());
  const std::string text = files::read_text(file);
  EXPECT_THAT(text, HasSubstr("\n\"rmse_m\": [0.1,0.3333333333333333],\n")) << "a metric is a line";
  const Baseline read = read_baseline(file);
  EXPECT_EQ(read.history.at(0).reason, "a \"first\" one");
  EXPECT_EQ(read.history.at(1).processor, "another");
  EXPECT_EQ(read.find("run"), nullptr);
  ASSERT_NE(read.find("walk"), nullptr);
  EXPECT_EQ(read.find("walk")->config, example().scenarios[0].config);
  write_baseline(file, read);
  EXPECT_EQ(files::read_text(file), text);
  for (const auto& [wrong, why] :
       {std::pair{text.substr(0, text.size() / 2), ": is not JSON or is cut off here"},
        {std::string("{}"), "ci.json: format_version: is missing"}}) {
    files::write_text(file, wrong);
    EXPECT_THAT(files::error_of([&] { read_baseline(file); }), HasSubstr(why));
  }
}

}  // namespace
}  // namespace sim::regression
