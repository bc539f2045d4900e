#include "slam/vision/match_bias.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/slam/random_filter.h"

namespace slam {
namespace {

Options::Vision with_lasting(double sigma_px) {
  Options::Vision options;
  options.match_bias_sigma_px = sigma_px;
  options.measured_landmarks = 2;
  return options;
}

struct ErrorScene {
  ErrorScene() {
    for (int id = 0; id < 9; ++id) {
      landmarks.emplace_back();
      landmarks.back().id = 10 + id;
    }
  }
  double variance(int at) const { return kalman.state().storage_P(at, at); }

  Options::Vision options = with_lasting(0.2);
  Kalman kalman{{RobotVector::Zero(), RobotMatrix::Identity()}, false, MatchBiases::places(options, {})};
  MatchBiases errors{options, {}};
  std::vector<Landmark> landmarks;
};

TEST(MatchBiases, HaveNoPlaceInTheStateWhereTheOptionsHaveNone) {
  EXPECT_EQ(MatchBiases::places(with_lasting(0), {}), 0);
  EXPECT_GT(MatchBiases::places(with_lasting(0.1), {}), 2);
  Options::Vision blind = with_lasting(0.1);
  blind.enabled = false;
  EXPECT_EQ(MatchBiases::places(blind, {}), 0);
}

TEST(MatchBiases, AreZeroAtFirstSightAndAsLargeAsTheyGetAfterALoss) {
  ErrorScene scene;
  const int fresh = scene.errors.add(10, true, scene.kalman), again = scene.errors.add(11, false, scene.kalman);
  EXPECT_EQ(scene.errors.at(10), fresh);
  EXPECT_EQ(scene.errors.at(11), again);
  EXPECT_EQ(scene.errors.at(12), -1);
  EXPECT_EQ(scene.variance(fresh), 0);
  EXPECT_NEAR(scene.variance(again), 0.04, 1e-15);
}

TEST(MatchBiases, GrowToTheVarianceOfTheOptionsAndNoFurther) {
  ErrorScene scene;
  const int at = scene.errors.add(10, true, scene.kalman);
  scene.errors.predict(scene.options.match_bias_s, scene.kalman);
  EXPECT_NEAR(scene.variance(at), 0.04 * (1 - std::exp(-2)), 1e-12);
  for (int k = 0; k < 20; ++k) scene.errors.predict(1, scene.kalman);
  EXPECT_NEAR(scene.variance(at), 0.04, 1e-6);
}

TEST(MatchBiases, LandmarksOutOfViewGiveTheirPlacesFree) {
  ErrorScene scene;
  const int count = MatchBiases::places(scene.options, {});
  for (int id = 10; id < 10 + count; ++id) EXPECT_GE(scene.errors.add(id, false, scene.kalman), kRobot);
  EXPECT_EQ(scene.errors.add(99, false, scene.kalman), -1);
  scene.errors.keep_visible({0, 2}, scene.landmarks, scene.kalman);
  EXPECT_GE(scene.errors.at(10), kRobot);
  EXPECT_EQ(scene.errors.at(11), -1);
  EXPECT_EQ(scene.variance(kRobot + 2), 0);
  EXPECT_GE(scene.errors.add(99, false, scene.kalman), kRobot);
  scene.errors.clear(scene.kalman);
  EXPECT_EQ(scene.errors.at(10), -1);
  EXPECT_EQ(scene.variance(kRobot), 0);
}

}  // namespace
}  // namespace slam
