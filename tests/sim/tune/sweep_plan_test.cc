#include "sim/tune/sweep_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "sim/tune/samples.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::tune {
namespace {

using scenario::ConfigError;
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
                 const Sampling& sampling = {}) const {
    return plan_sweep(read_sweep(folder_ / file, arguments, sampling), {1, 2}, {});
  }
  std::string complaint(const std::string& file, const std::vector<std::string>& arguments) const {
    try {
      plan(file, arguments);
    } catch (const ConfigError& e) {
      const std::string text = e.what(), folder = folder_.path().string() + "/";
      return text.starts_with(folder) ? text.substr(folder.size()) : text;
    }
    return "";
  }
  std::string complaint_of_spec(const std::string& text) const {
    write("spec.yaml", text);
    return complaint("spec.yaml", {});
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
  const SweepPlan grid =
      plan("walk.yaml", {"slam.vision.sigma_px=1,2", "slam.gyro.sigma_rad_s=range(0.01,0.03,0.01)"});
  EXPECT_THAT(grid.keys, ElementsAre("slam.vision.sigma_px", "slam.gyro.sigma_rad_s"));
  EXPECT_THAT(values(grid),
              ElementsAre(ElementsAre("1", "0.01"), ElementsAre("1", "0.02"), ElementsAre("1", "0.03"),
                          ElementsAre("2", "0.01"), ElementsAre("2", "0.02"), ElementsAre("2", "0.03")));
  EXPECT_EQ(grid.trials(), 12u);
  EXPECT_EQ(grid.scenario(11).scenario.slam->vision.sigma_px, 2);
  EXPECT_EQ(grid.scenario(11).scenario.seed, 2u);
}

TEST_F(Sweep, ZipKeepsPairsTogether) {
  const SweepPlan pairs =
      plan("walk.yaml", {"zip(slam.vision.sigma_px=1,2, slam.height.sigma_m=0.1,0.2)", "world.seed=1,2"});
  EXPECT_THAT(values(pairs), ElementsAre(ElementsAre("1", "0.1", "1"), ElementsAre("1", "0.1", "2"),
                                         ElementsAre("2", "0.2", "1"), ElementsAre("2", "0.2", "2")));
}

TEST_F(Sweep, SamplesOfTheCommandLineAreDrawnTogether) {
  const std::vector<std::string> keys{"slam.vision.sigma_px=loguniform(0.1, 10)",
                                      "slam.gyro.sigma_rad_s=uniform(0, 1)"};
  const auto sobol = values(plan("walk.yaml", keys, {3, "sobol", 0}));
  EXPECT_THAT(sobol, ElementsAre(ElementsAre("1", "0.5"), ElementsAre("3.16227766017", "0.25"),
                                 ElementsAre("0.316227766017", "0.75")));
  EXPECT_NE(values(plan("walk.yaml", keys, {3, "random", 0})), sobol);
}

TEST_F(Sweep, AFileSaysTheSameAsTheCommandLine) {
  write("spec.yaml", R"yaml(
scenarios: [walk.yaml]
seeds: 1..5
grid:
  slam.vision.sigma_px: logspace(1, 100, 3)
  slam.vision.sub_pixel: [true, false]
zip:
  - {slam.height.sigma_m: [0.1, 0.2], slam.gyro.sigma_rad_s: "linspace(1, 2, 2)"}
sample: {method: random, points: 4, seed: 3, keys: {slam.depth.inverse_1_m: "uniform(0.1, 1)"}}
)yaml");
  const SweepSpec spec = read_sweep(folder_ / "spec.yaml", {"world.seed=5,6"}, {});
  EXPECT_THAT(spec.seeds, ElementsAre(1, 2, 3, 4, 5));
  const SweepPlan all = plan_sweep(spec, {1}, {});
  EXPECT_EQ(all.configurations.size(), 3u * 2 * 2 * 4 * 2);
  EXPECT_THAT(all.configurations.back().values, ElementsAre("100", "false", "0.2", "2", testing::_, "6"));
}

TEST_F(Sweep, WhatIsWrongOnTheCommandLineIsNamedWithItsPlace) {
  EXPECT_EQ(complaint("walk.yaml", {"slam.vision.sigma=1,2"}),
            "<argument>:1:1: slam.vision.sigma: unknown key; did you mean 'slam.vision.sigma_px'?");
  EXPECT_THAT(complaint("walk.yaml", {"world.seed=1", "slam.vision.sigma_px=1,x"}),
              StartsWith("<argument>:2:24: slam.vision.sigma_px: is 'x', expected a number"));
  EXPECT_THAT(complaint("walk.yaml", {"slam.vision.sigma_px=1,,2"}),
              StartsWith("<argument>:1:24: a value is missing"));
  EXPECT_THAT(complaint("walk.yaml", {"slam.vision.sigma_px"}), HasSubstr("expected KEY=VALUE,VALUE"));
  EXPECT_THAT(complaint("walk.yaml", {"zip(slam.vision.sigma_px=1,2, slam.height.sigma_m=1)"}),
              HasSubstr("slam.height.sigma_m: has 1 values, and slam.vision.sigma_px has 2"));
  EXPECT_THAT(complaint("walk.yaml", {"slam.vision.sigma_px=1", "slam.vision.sigma_px=2"}),
              StartsWith("<argument>:2:1: slam.vision.sigma_px: is given values twice"));
  EXPECT_THAT(complaint("walk.yaml", {"seed=1,2"}), EndsWith("expected seeds (--seeds 1..5)"));
  EXPECT_THAT(complaint("walk.yaml", {"limits.rmse_m=1"}), HasSubstr("does not change a run"));
  EXPECT_THAT(complaint("blind.yaml", {"slam.vision.sigma_px=1"}), HasSubstr("blind has no such section"));
  EXPECT_THAT(complaint("walk.yaml", {"slam.vision.sigma_px=loguniform(0, 1)"}), HasSubstr("bounds above 0"));
  EXPECT_THAT(complaint("walk.yaml", {"slam.vision.sigma_px=uniform(1, 1)"}), HasSubstr("1 is not below 1"));
  EXPECT_THAT(complaint("none.yaml", {}), HasSubstr("cannot be read"));
}

TEST_F(Sweep, WhatIsWrongInAFileIsNamedWithItsPlace) {
  EXPECT_EQ(complaint_of_spec("scenario: walk.yaml\ngird: {}\n"),
            "spec.yaml:2:1: gird: unknown key; did you mean 'grid'?");
  EXPECT_THAT(complaint_of_spec("scenario: walk.yaml\ngrid:\n  slam.vision.sigma_px: [1, -2]\n"),
              StartsWith("spec.yaml:3:29: slam.vision.sigma_px: is '-2', expected a number"));
  EXPECT_THAT(complaint_of_spec("scenario: walk.yaml\ngrid:\n  slam.vision.sigma_px: logspace(1, 2)\n"),
              StartsWith("spec.yaml:3:25: logspace(...): has 2 numbers"));
  EXPECT_THAT(complaint_of_spec("grid: {slam.vision.sigma_px: [1]}\n"),
              StartsWith("spec.yaml:1:1: scenario: missing"));
  EXPECT_THAT(complaint_of_spec("scenarios: []\n"), StartsWith("spec.yaml:1:12: scenarios: expected a list"));
  EXPECT_THAT(complaint_of_spec("scenario: walk.yaml\nsample: {method: sobl, keys: {}}\n"),
              HasSubstr("did you mean 'sobol'?"));
  EXPECT_THAT(complaint_of_spec("scenario: walk.yaml\nsample: {points: 0}\n"),
              StartsWith("spec.yaml:2:18: sample.points:"));
  EXPECT_THAT(complaint_of_spec("scenario: walk.yaml\nsample: {points: 3}\n"),
              HasSubstr("sample.keys: missing"));
  EXPECT_THAT(complaint_of_spec("scenario: walk.yaml\nseeds: [1, 2]\n"),
              StartsWith("spec.yaml:2:8: seeds: expected seeds"));
  EXPECT_THAT(complaint_of_spec("scenarios: [walk.yaml, walk.yaml]\n"),
              HasSubstr("a sweep needs names that differ"));
  EXPECT_THAT(complaint_of_spec(
                  "scenario: walk.yaml\ngrid:\n  world.seed: range(1, 100000, 1)\n  slam.vision.sigma_px: "
                  "range(1, 20, 1)\n"),
              EndsWith("2000000 combinations, expected at most 100000"));
}

TEST_F(Sweep, MoreTrialsThanAnyoneWaitsForAreRefusedAtTheKeyThatAsksForThem) {
  EXPECT_EQ(complaint_of_spec("scenario: walk.yaml\ngrid:\n  world.seed: range(1, 1000, 1)\n"
                              "  slam.vision.sigma_px: 'linspace(1, 2, 101)'\n"),
            "spec.yaml:4:3: slam.vision.sigma_px: makes 101000 combinations, expected at most 100000");
  EXPECT_EQ(complaint("walk.yaml", {"slam.vision.sigma_px=linspace(1,2,100000),linspace(3,4,100000)"}),
            "<argument>:1:43: makes 200000 values, expected at most 100000");
  EXPECT_EQ(complaint_of_spec("scenario: walk.yaml\nsample: {points: 1000000, keys: "
                              "{slam.vision.sigma_px: 'uniform(1, 2)'}}\n"),
            "spec.yaml:2:18: sample.points: is '1000000', expected a whole number from 1 to 100000");
  write("spec.yaml", "scenarios: [walk.yaml, blind.yaml]\ngrid: {world.seed: 'range(1, 1000, 1)'}\n");
  const SweepSpec spec = read_sweep(folder_ / "spec.yaml", {}, {});
  std::vector<std::uint64_t> seeds(51);
  EXPECT_THAT(
      [&] { plan_sweep(spec, seeds, {}); },
      testing::ThrowsMessage<scenario::ConfigError>(EndsWith(
          "spec.yaml:2:8: world.seed: makes 102000 trials of 1000 combinations, 2 scenarios and 51 seeds, "
          "expected at most 100000")));
}

}  // namespace
}  // namespace sim::tune
