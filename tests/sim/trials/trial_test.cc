// The likelihood of a pose against values computed by hand, and trials from memory against replays from the
// disk.
#include "sim/trials/trial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <thread>

#include "sim/replay/replay.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/result/result_folder.h"
#include "tests/sim/trials/synthetic_result.h"

namespace sim::trials {
namespace {

// The position's x is correlated with the rotation about x.
TEST(PoseNll, IsThatOfTheDensityOfTheErrorWithItsCorrelations) {
  score::Matrix6d P = score::Matrix6d::Identity() * 1e-4;
  P(0, 3) = P(3, 0) = 0.6e-4;  // |P| = 1e-24 (1 − 0.36)
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.translation().x() = 0.03;                                               // 3 σ
  truth.linear() = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()).matrix();  // 2 σ
  const double expected = (9 / 0.64 + 4 + std::log(0.64e-24) + 6 * std::log(2 * std::numbers::pi)) / 2;
  EXPECT_NEAR(pose_nll(truth, Eigen::Isometry3d::Identity(), P).value(), expected, 1e-9);
}

TEST(PoseNll, HasNoValueWhereACovarianceIsNotPositiveDefinite) {
  score::Matrix6d P = score::Matrix6d::Identity();
  P(2, 2) = -1;
  EXPECT_FALSE(pose_nll(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity(), P));
}

constexpr int kFrames = 40;

// One result folder for all tests of this program.
class Trials : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::filesystem::temp_directory_path() / ("gaitslam trials " + std::to_string(getpid()));
    tests::write_result(folder_, tests::short_walk(kFrames));
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder_); }

  static scenario::ReadScenario scenario(const std::vector<std::string>& overrides) {
    return scenario::read_scenario(folder_ / "scenario.yaml", {overrides, {}});
  }
  // score.json of a replay from the disk.
  static nlohmann::json replayed(const scenario::ReadScenario& scenario) {
    const result::ResultPlace place{folder_ / "replay", files::Existing::replace, {}, "1", "test", {}};
    replay::replay(scenario, folder_ / "recording", {{scenario::Ending::completed}}, place, [](double) {});
    return tests::json_of(folder_ / "replay" / "score.json");
  }

  static inline std::filesystem::path folder_;
};

void expect_same(const Trial& trial, const nlohmann::json& score) {
  EXPECT_EQ(name_of(trial.ended.ending), score["ending"].get<std::string>());
  ASSERT_EQ(trial.metrics.size(), score["metrics"].size());
  for (const auto& [name, metric] : trial.metrics) {
    const nlohmann::json& there = score["metrics"][name];
    ASSERT_EQ(metric.value.has_value(), there["value"].is_number()) << name;
    if (metric.value)
      EXPECT_EQ(*metric.value, there["value"].get<double>()) << name;
    else
      EXPECT_EQ(metric.reason, there["reason"]) << name;
  }
}

TEST_F(Trials, HaveTheMetricsOfAReplayBitForBit) {
  const Recording ideal = load(folder_);
  EXPECT_EQ(ideal.observations.size(), static_cast<std::size_t>(kFrames));
  for (const std::string change : {"slam.vision.sigma_px=0.7", "seed=5", "errors.image.loss_fraction=0.3"}) {
    const scenario::ReadScenario changed = scenario({change});
    const nlohmann::json score = replayed(changed);
    ASSERT_TRUE(score["metrics"]["rmse_m"]["value"].is_number()) << score.dump(1);
    expect_same(run_trial(ideal, changed), score);
    expect_same(run_trial(load(folder_, changed.scenario), changed), score);
  }
}

TEST_F(Trials, OfOneRecordingInTwoThreadsGiveTheSameBits) {
  const Recording recording = load(folder_, scenario({}).scenario);
  const std::vector<scenario::ReadScenario> wanted{scenario({}), scenario({"slam.gyro.sigma_rad_s=0.03"})};
  std::vector<Trial> alone, together(2);
  for (const auto& s : wanted) alone.push_back(run_trial(recording, s));
  {
    std::jthread first([&] { together[0] = run_trial(recording, wanted[0]); });
    std::jthread second([&] { together[1] = run_trial(recording, wanted[1]); });
  }
  EXPECT_NE(alone[0].pose_nll, alone[1].pose_nll);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(alone[i].pose_nll, together[i].pose_nll);
}

TEST_F(Trials, ThatAskForOtherErrorsThanTheRecordingHasInItAreRefused) {
  const Recording recording = load(folder_, scenario({}).scenario);
  EXPECT_THROW(run_trial(recording, scenario({"errors.gyro.sigma_rad_s=0.5"})), std::logic_error);
  EXPECT_THROW(run_trial(recording, scenario({"seed=2"})), std::logic_error);
}

TEST_F(Trials, OfAFilterThatFailsHaveNoLikelihoodButTellHowLongItLasted) {
  // No landmark is ever found again at a correlation of 1.
  const auto failing = scenario(
      {"slam.vision.minimum_correlation=1", "slam.tracking.lost_after_s=0.3", "slam.tracking.give_up_s=0.3"});
  const Trial trial = run_trial(load(folder_), failing);
  EXPECT_EQ(trial.ended.ending, scenario::Ending::diverged);
  EXPECT_FALSE(trial.pose_nll);
  EXPECT_GT(trial.lasted_fraction, 0);
  EXPECT_LT(trial.lasted_fraction, 1);
}

}  // namespace
}  // namespace sim::trials
