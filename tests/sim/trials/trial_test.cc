// The likelihoods of poses and innovations against values computed by hand, trials from memory against
// replays from the disk.
#include "sim/trials/trial.h"

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

/// The innovations of a Kalman filter that assumes a standard deviation of its measurements of a random walk.
/// That of the steps is 0.1 and known, that of the measurements is 0.2.
tracking::Tracked random_walk(double assumed_sigma) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  tracking::Tracked tracked;
  double x = 0, estimate = 0, P = 0;
  for (int k = 0; k < 2000; ++k) {
    x += 0.1 * normal(random);
    P += 0.01;
    const double nu = x + 0.2 * normal(random) - estimate, S = P + assumed_sigma * assumed_sigma;
    tracked.frames.emplace_back().report.innovations = {{"height", {nu * nu / S, 1, std::log(S)}}};
    estimate += P / S * nu;
    P -= P * P / S;
  }
  return tracked;
}

TEST(InnovationNll, IsLeastForTheTrueNoise) {
  const double true_noise = innovation_nll(random_walk(0.2), 1).value();
  for (const double wrong : {0.1, 0.14, 0.28, 0.4})
    EXPECT_GT(innovation_nll(random_walk(wrong), 1).value(), true_noise + 0.01) << wrong;
}

/// A frame with `used` matches among the landmarks searched for, each with a NIS of 2 and S = 0.01 px² I.
tracking::TrackedFrame searched(std::size_t used, std::size_t landmarks) {
  tracking::TrackedFrame frame;
  frame.report.searched.resize(landmarks);
  const int count = static_cast<int>(used);
  if (used > 0) frame.report.innovations = {{"vision", {2.0 * count, 2 * count, count * std::log(1e-4)}}};
  return frame;
}

TEST(InnovationNll, DoesNotDependOnTheNumberOfLandmarksButOnThePartThatIsFound) {
  const double found = 2 + std::log(1e-4) + 2 * std::log(2 * std::numbers::pi), missed = 2 * std::log(76800);
  const std::vector<std::pair<std::vector<tracking::TrackedFrame>, double>> cases{
      {{searched(4, 4)}, found / 4},
      {{searched(6, 6), searched(12, 12)}, found / 4},
      {{searched(9, 12)}, (3 * found + missed) / 16},
      {{searched(6, 8), searched(0, 0), searched(3, 4)}, (3 * found + missed) / 16},
      {{searched(0, 8)}, missed / 4}};
  for (const auto& [frames, expected] : cases) {
    tracking::Tracked tracked;
    tracked.frames = frames;
    EXPECT_NEAR(innovation_nll(tracked, 76800).value(), expected, 1e-12);
  }
}

TEST(InnovationNll, IsTheSumOverTheSensorsOfTheirMeans) {
  tracking::Tracked both = random_walk(0.2);
  for (tracking::TrackedFrame& frame : both.frames)
    frame.report.innovations.push_back({"gyro", {3, 3, -3 * std::log(2 * std::numbers::pi)}});
  EXPECT_NEAR(innovation_nll(both, 1).value(), innovation_nll(random_walk(0.2), 1).value() + 0.5, 1e-12);
}

TEST(InnovationNll, HasNoValueWithoutInnovationsOrWhereACovarianceIsNotPositiveDefinite) {
  EXPECT_FALSE(innovation_nll({}, 1));
  tracking::Tracked tracked = random_walk(0.2);
  tracked.frames.back().report.innovations.front().nis.value = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(innovation_nll(tracked, 1));
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

void expect_same(const JobRecord& trial, const nlohmann::json& score) {
  EXPECT_EQ(trial.ending, score["ending"].get<std::string>());
  for (const auto& [name, metric] : score["metrics"].items()) {
    const auto value = trial.value(name);
    EXPECT_EQ(value ? nlohmann::json(*value) : nlohmann::json(), metric["value"]) << name;
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
  }
}

TEST_F(Trials, OfAFilterThatFailsHaveNoLikelihoodButTellHowLongItLasted) {
  // No landmark is ever found again at a correlation of 1.
  const auto failing = scenario(
      {"slam.vision.minimum_correlation=1", "slam.tracking.lost_after_s=0.3", "slam.tracking.give_up_s=0.3"});
  const JobRecord trial = run_trial(load(folder_), failing);
  EXPECT_EQ(trial.ending, "diverged");
  EXPECT_FALSE(trial.value("pose_nll"));
  EXPECT_FALSE(trial.value("innovation_nll"));
  EXPECT_GT(trial.value("lasted_fraction"), 0);
  EXPECT_LT(trial.value("lasted_fraction"), 1);
}

}  // namespace
}  // namespace sim::trials
