// Specs of tunings, right ones and wrong ones.
#include "sim/trials/spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/scenario/complaint.h"

namespace sim::trials {
namespace {

using testing::HasSubstr;

// A folder of recordings by their looks, which is all that a spec asks for.
class SpecFile : public testing::Test {
 protected:
  SpecFile() {
    for (int seed = 1; seed <= 3; ++seed) {
      const std::filesystem::path result = folder_ / ("walks/seed-" + std::to_string(seed));
      std::filesystem::create_directories(result / "recording");
      std::ofstream(result / "recording" / "manifest.csv") << '\n';
      std::ofstream(result / "scenario.yaml")
          << "seed: " << seed
          << "\nwalk: {commands: [stand: {duration_s: 1}]}\ncamera: {}\nslam: {gyro.sigma_rad_s: 0.02}\n";
    }
  }
  Spec read(const std::string& text) const {
    std::ofstream(folder_ / "spec.yaml") << text;
    return read_spec(folder_ / "spec.yaml");
  }
  /// The error of reading it, without the folder.
  std::string complaint(const std::string& text) const {
    const std::string what = scenario::complaint_of([&] { read(text); });
    return what.substr(std::min(what.find("spec.yaml"), what.size()));
  }

  static constexpr const char* kSides =
      "training: [{recordings: walks, seeds: 1..2}]\nholdout: [{recordings: walks/seed-3}]\n";
  files::TemporaryFolder folder_;
};

TEST_F(SpecFile, SaysWhatIsTunedOnWhatAndByWhat) {
  const Spec spec = read(
      "parameters:\n  slam.gyro.sigma_rad_s: {from: 0.001, to: 0.1}\n"
      "  slam.vision.sigma_px: {from: 0.1, to: 4, start: 2, also: [slam.vision.gate_sigma_px]}\n"
      "training: [{recordings: walks, seeds: '1,3', set: [slam.height.sigma_m=0.1]}]\n"
      "holdout: [{recordings: walks/seed-2}]\nobjective: rmse_m\ntrials: 90\nseed: 7\n");
  EXPECT_EQ(spec.name, "spec");
  ASSERT_EQ(spec.parameters.size(), 2U);
  EXPECT_EQ(spec.parameters[0].start, 0.02);  // of the recorded scenario
  EXPECT_EQ(spec.parameters[1].also, std::vector<std::string>{"slam.vision.gate_sigma_px"});
  ASSERT_EQ(spec.training.size(), 2U);
  EXPECT_EQ(spec.training[1].folder, (folder_ / "walks/seed-3"));
  EXPECT_EQ(spec.training[1].name, "walks/seed-3");
  EXPECT_EQ(spec.objective, Objective::rmse_m);
  EXPECT_EQ(spec.trials, 90);
}

TEST_F(SpecFile, IsRefusedWithItsPlaceWhereItIsWrong) {
  const std::string range = "{from: 0.001, to: 0.1}",
                    gyro = "parameters: {slam.gyro.sigma_rad_s: " + range + "}\n";
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"parameters: {slam.gyro.sigma_rads: " + range + "}\n",
       "spec.yaml:1:14: slam.gyro.sigma_rads: unknown key; did you mean"},
      {"parameters: {walk.step_length_m: " + range + "}\n",
       "spec.yaml:1:14: walk.step_length_m: shapes the recording"},
      {"parameters: {slam.gyro.enabled: " + range + "}\n",
       "spec.yaml:1:14: slam.gyro.enabled: is true or false"},
      {"parameters: {slam.gyro.sigma_rad_s: {from: 0.1, to: 1}}\n" + std::string(kSides),
       "starts at 0.02, outside"},
      {gyro, "training: missing"},
      {gyro + "training: [{recordings: walks, seeds: 1}]\n", "holdout: missing"},
      {gyro + "training: [{recordings: walks}]\n", "spec.yaml:2:25: recordings: "},
      {gyro + "training: [{recordings: walks, seeds: 1..9}]\n", "has no finished recording"},
      {gyro + "training: [{recordings: walks, seeds: 3..1}]\n", "spec.yaml:2:39: seeds: "},
      {gyro + "training: []\n", "spec.yaml:2:11: training: expected a list"},
      {gyro + "training: [{recordings: walks, seeds: 1..3}]\nholdout: [{recordings: walks/seed-3}]\n",
       "spec.yaml:3:11: holdout: seed 3 of scenario is also in the training"},
      {gyro +
           "training: [{recordings: walks/seed-2}]\nholdout: [{recordings: walks/seed-2, set: [seed=9]}]\n",
       "spec.yaml:3:11: holdout: seed 2 of scenario is also in the training"},
      {gyro + kSides + "objective: nll\n", "spec.yaml:4:12: objective: "},
      {gyro + kSides + "trials: 10\n", "too few for a population of 10"},
      {gyro + kSides + "trails: 20\n", "spec.yaml:4:1: trails: unknown key; did you mean 'trials'?"},
      {"- a\n", "expected a tuning"},
  };
  for (const auto& [text, complaint_] : wrong) EXPECT_THAT(complaint(text), HasSubstr(complaint_)) << text;
}

TEST_F(SpecFile, MayTakeAllButTheWalkFromAnotherScenario) {
  const std::string gyro = "parameters: {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.1}}\n",
                    sides =
                        "training: [{recordings: walks/seed-1, scenario: new.yaml}]\nholdout: [{recordings: "
                        "walks/seed-3}]\n";
  std::ofstream(folder_ / "new.yaml")
      << "walk: {commands: [stand: {duration_s: 1}]}\ncamera: {}\nslam: {gyro.sigma_rad_s: 0.05}\n";
  EXPECT_EQ(read(gyro + sides).parameters[0].start, 0.05);
  std::ofstream(folder_ / "new.yaml") << "walk: {commands: [stand: {duration_s: 2}]}\ncamera: {}\nslam: {}\n";
  EXPECT_THAT(complaint(gyro + sides), HasSubstr("spec.yaml:2:12: walk.commands: is "));
}

TEST_F(SpecFile, MayNameScenariosWhoseRecordingsTheCacheHas) {
  const std::string gyro = "parameters: {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.1}}\n";
  std::ofstream(folder_ / "walk.yaml")
      << "seed: 7\nwalk: {commands: [stand: {duration_s: 1}]}\ncamera: {}\nslam: {gyro.sigma_rad_s: 0.05}\n";
  const Spec spec = read(gyro +
                         "training: [{scenario: walk.yaml, seeds: 2..4, set: [slam.height.sigma_m=0.1]}]\n"
                         "holdout: [{scenario: walk.yaml}]\n");
  ASSERT_EQ(spec.training.size(), 3U);
  EXPECT_EQ(spec.training[1].name, "walk/seed-3");
  EXPECT_EQ(spec.training[1].folder, "");
  EXPECT_EQ(spec.training[1].read.scenario.seed, 3U);
  EXPECT_EQ(spec.training[1].read.scenario.slam->height.sigma_m, 0.1);
  EXPECT_EQ(spec.holdout[0].recorded_seed, 7U);
  EXPECT_EQ(spec.parameters[0].start, 0.05);
  EXPECT_THAT(complaint(gyro + "training: [{seeds: 1..2}]\n"),
              HasSubstr("spec.yaml:2:12: training: expected a scenario"));
  EXPECT_THROW(read(gyro + "training: [{scenario: none.yaml}]\n"), scenario::ConfigError);
}

}  // namespace
}  // namespace sim::trials
