// Checks the likelihoods of poses and innovations against values computed by hand, and a trial that fails.
#include "sim/trials/trial.h"

#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/trials/synthetic_result.h"

namespace sim::trials {
namespace {

// The position's x is correlated with the rotation about x.
TEST(PoseNll, FollowsFromTheDensityOfTheErrorIncludingCorrelations) {
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

/// The innovations of a Kalman filter for a random walk that assumes some standard deviation of its
/// measurements. The standard deviation of the steps is 0.1 and known; the measurements' is 0.2.
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

TEST(InnovationNll, DependsOnTheFractionOfLandmarksFoundNotOnTheirNumber) {
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

TEST(InnovationNll, IsTheSumOfTheSensorsMeans) {
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

// No landmark is ever found again if a correlation of 1 is required.
TEST(Trial, AFailingFilterHasNoLikelihoodButReportsHowLongItLasted) {
  const files::TemporaryFolder folder;
  tests::write_result(folder.path(), tests::short_walk(40));
  const auto failing = scenario::read_scenario(
      folder / "scenario.yaml",
      {{"slam.vision.minimum_correlation=1", "slam.tracking.lost_after_s=0.3", "slam.tracking.give_up_s=0.3"},
       {}});
  const JobRecord trial = run_trial(load(folder.path()), failing);
  EXPECT_EQ(trial.ending, "diverged");
  EXPECT_FALSE(trial.value("pose_nll"));
  EXPECT_FALSE(trial.value("innovation_nll"));
  EXPECT_GT(trial.value("lasted_fraction"), 0);
  EXPECT_LT(trial.value("lasted_fraction"), 1);
}

}  // namespace
}  // namespace sim::trials
