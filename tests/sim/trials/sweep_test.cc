// Plans of sweeps, right ones and wrong ones.
#include "sim/trials/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/sim/files/temporary_folder.h"

namespace sim::trials {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

class Sweep : public testing::Test {
 protected:
  Sweep() {
    write("walk.yaml", "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n");
    write("blind.yaml", "walk: {commands: [{stand: {duration_s: 1}}]}\n");
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }

  SweepPlan plan(const std::string& file, const std::vector<std::string>& arguments,
                 std::optional<int> samples = {}, const std::vector<std::uint64_t>& seeds = {1, 2}) const {
    return plan_sweep(read_sweep(folder_ / file, arguments, samples), seeds, {});
  }
  std::string complaint(const std::string& file, const std::vector<std::string>& arguments,
                        std::size_t seeds = 2) const {
    try {
      plan(file, arguments, {}, std::vector<std::uint64_t>(seeds));
    } catch (const scenario::ConfigError& e) {
      const std::string text = e.what(), folder = folder_.path().string() + "/";
      return text.starts_with(folder) ? text.substr(folder.size()) : text;
    }
    return "";
  }
  std::string complaint_of_file(const std::string& text, std::size_t seeds = 2) const {
    write("spec.yaml", text);
    return complaint("spec.yaml", {}, seeds);
  }

  static std::vector<std::vector<std::string>> values(const SweepPlan& plan) {
    std::vector<std::vector<std::string>> all;
    for (const Configuration& configuration : plan.configurations) all.push_back(configuration.values);
    return all;
  }

  files::TemporaryFolder folder_;
};

TEST_F(Sweep, OfAScenarioAloneIsThatScenarioOnEachSeed) {
  const SweepPlan one = plan("walk.yaml", {});
  EXPECT_EQ(one.trials(), 2u);
  EXPECT_EQ(one.scenario(1).scenario.seed, 2u);
  EXPECT_EQ(one.scenario(1).scenario.name, "walk");
}

TEST_F(Sweep, TriesEveryCombinationTheLastKeyFastest) {
  const SweepPlan grid = plan("walk.yaml", {"slam.vision.sigma_px=1,2",
                                            "slam.gyro.sigma_rad_s={from: 0.01, to: 0.03, points: 3, "
                                            "scale: linear, also: [slam.height.sigma_m]}"});
  EXPECT_THAT(grid.keys, ElementsAre("slam.vision.sigma_px", "slam.gyro.sigma_rad_s", "slam.height.sigma_m"));
  EXPECT_THAT(values(grid), ElementsAre(ElementsAre("1", "0.01", "0.01"), ElementsAre("1", "0.02", "0.02"),
                                        ElementsAre("1", "0.03", "0.03"), ElementsAre("2", "0.01", "0.01"),
                                        ElementsAre("2", "0.02", "0.02"), ElementsAre("2", "0.03", "0.03")));
  EXPECT_EQ(grid.trials(), 12u);
  EXPECT_EQ(grid.scenario(11).scenario.slam->vision.sigma_px, 2);
  EXPECT_EQ(grid.scenario(11).scenario.seed, 2u);
}

TEST_F(Sweep, RangesWithoutPointsAreSampledTogether) {
  const std::vector<std::string> keys{"slam.vision.sigma_px={from: 0.1, to: 10}",
                                      "errors.gyro.sigma_rad_s={from: 0, to: 1, scale: linear}"};
  EXPECT_THAT(values(plan("walk.yaml", keys, 3)),
              ElementsAre(ElementsAre("1", "0.5"), ElementsAre("3.16227766017", "0.25"),
                          ElementsAre("0.316227766017", "0.75")));
  EXPECT_EQ(plan("walk.yaml", keys).configurations.size(), 16u);
}

TEST_F(Sweep, AFileSaysTheSameAsTheCommandLine) {
  write("spec.yaml", R"yaml(
scenarios: [walk.yaml]
seeds: 1..5
parameters:
  slam.vision.sigma_px: {from: 1, to: 100, points: 3}
  slam.vision.sub_pixel: [true, false]
  walk.commands: [[{stand: {duration_s: 1}}], [{stand: {duration_s: 2}}]]
  slam.depth.inverse_1_m: {from: 0.1, to: 1}
samples: 4
)yaml");
  const SweepSpec spec = read_sweep(folder_ / "spec.yaml", {"world.seed=5,6"});
  EXPECT_THAT(spec.seeds, ElementsAre(1, 2, 3, 4, 5));
  const SweepPlan all = plan_sweep(spec, {1}, {});
  EXPECT_EQ(all.configurations.size(), 3u * 2 * 2 * 4 * 2);
  EXPECT_THAT(all.configurations.back().values,
              ElementsAre("100", "false", "[{stand: {duration_s: 2}}]", "6", testing::_));
  EXPECT_THAT(
      values(plan("walk.yaml", {"walk.commands=[{stand: {duration_s: 1}}],[{stand: {duration_s: 2}}]"})),
      ElementsAre(ElementsAre("[{stand: {duration_s: 1}}]"), ElementsAre("[{stand: {duration_s: 2}}]")));
}

TEST_F(Sweep, WhatIsWrongOnTheCommandLineIsNamedWithItsPlace) {
  const auto expect = [&](const std::vector<std::string>& arguments, const std::string& text) {
    EXPECT_THAT(complaint("walk.yaml", arguments), HasSubstr(text));
  };
  EXPECT_EQ(complaint("walk.yaml", {"slam.vision.sigma=1,2"}),
            "<argument>:1:1: slam.vision.sigma: unknown key; did you mean 'slam.vision.sigma_px'?");
  expect({"world.seed=1", "slam.vision.sigma_px=1,x"},
         "<argument>:2:24: slam.vision.sigma_px: is 'x', expected a number");
  expect({"slam.vision.sigma_px=1,,2"}, "<argument>:1:24: ");
  expect({"slam.vision.sigma_px"}, "expected KEY=VALUE,VALUE");
  expect({"slam.vision.sigma_px=1", "slam.vision.sigma_px=2"},
         "<argument>:2:1: slam.vision.sigma_px: is given values twice");
  expect({"seed=1,2"}, "expected seeds (--seeds 1..5)");
  expect({"limits.rmse_m=1"}, "does not change a run");
  EXPECT_THAT(complaint("blind.yaml", {"slam.vision.sigma_px=1"}), HasSubstr("blind has no such section"));
  EXPECT_THAT(complaint("none.yaml", {}), HasSubstr("cannot be read"));
}

TEST_F(Sweep, WhatIsWrongInAFileIsNamedWithItsPlace) {
  const auto expect = [&](const std::string& text, const std::string& what) {
    EXPECT_THAT(complaint_of_file(text), HasSubstr(what)) << text;
  };
  expect("scenario: walk.yaml\nsede: 1\n", "spec.yaml:2:1: sede: unknown key; did you mean 'seeds'?");
  expect("scenario: walk.yaml\nparameters:\n  slam.vision.sigma_px: [1, -2]\n",
         "spec.yaml:3:29: slam.vision.sigma_px: is '-2', expected a number");
  expect("parameters: {slam.vision.sigma_px: [1]}\n", "spec.yaml:1:1: scenario: missing");
  expect("scenarios: []\n", "spec.yaml:1:12: scenarios: expected a list");
  expect("scenario: walk.yaml\nsamples: 1000000\n",
         "spec.yaml:2:10: samples: is '1000000', expected a whole number from 1 to 100000");
  expect("scenario: walk.yaml\nseeds: [1, 2]\n", "spec.yaml:2:8: seeds: expected seeds");
  expect("scenarios: [walk.yaml, walk.yaml]\n", "a sweep needs different names");
}

TEST_F(Sweep, MoreTrialsThanAnyoneWaitsForAreRejectedAtTheKeyThatAsksForThem) {
  const std::string thousand = "{from: 1, to: 1000, points: 1000, scale: linear}";
  EXPECT_EQ(complaint_of_file("scenario: walk.yaml\nparameters:\n  world.seed: " + thousand +
                              "\n  slam.vision.sigma_px: {from: 1, to: 2, points: 101}\n"),
            "spec.yaml:4:3: slam.vision.sigma_px: makes 101000 combinations, expected at most 100000");
  EXPECT_THAT(complaint_of_file(
                  "scenarios: [walk.yaml, blind.yaml]\nparameters: {world.seed: " + thousand + "}\n", 51),
              EndsWith("world.seed: makes 102000 trials of 1000 combinations, 2 scenarios and 51 seeds, "
                       "expected at most 100000"));
  EXPECT_THAT(complaint_of_file("scenario: walk.yaml\nparameters: {world.seed: {from: 1, to: 200000, points: "
                                "100001, scale: linear}}\n"),
              HasSubstr("points: is '100001', expected a whole number from 2 to 100000"));
}

}  // namespace
}  // namespace sim::trials
