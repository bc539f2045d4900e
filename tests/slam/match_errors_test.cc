#include "slam/match_errors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/slam/random_filter.h"

namespace slam {
namespace {

Options::Vision with_lasting(double sigma_px) {
  Options::Vision options;
  options.sigma_lasting_px = sigma_px;
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
  Kalman kalman{{RobotVector::Zero(), RobotMatrix::Identity()}, false, MatchErrors::places(options, {})};
  MatchErrors errors{options, {}};
  std::vector<Landmark> landmarks;
};

TEST(MatchErrors, HaveNoPlaceInTheStateWhereTheOptionsHaveNone) {
  EXPECT_EQ(MatchErrors::places(with_lasting(0), {}), 0);
  EXPECT_GT(MatchErrors::places(with_lasting(0.1), {}), 2);
  Options::Vision blind = with_lasting(0.1);
  blind.enabled = false;
  EXPECT_EQ(MatchErrors::places(blind, {}), 0);
}

TEST(MatchErrors, AreZeroAtFirstSightAndAsLargeAsTheyGetAfterALoss) {
  ErrorScene scene;
  const int fresh = scene.errors.add(10, true, scene.kalman), again = scene.errors.add(11, false, scene.kalman);
  EXPECT_EQ(scene.errors.at(10), fresh);
  EXPECT_EQ(scene.errors.at(11), again);
  EXPECT_EQ(scene.errors.at(12), -1);
  EXPECT_EQ(scene.variance(fresh), 0);
  EXPECT_NEAR(scene.variance(again), 0.04, 1e-15);
}

TEST(MatchErrors, GrowToTheVarianceOfTheOptionsAndNoFurther) {
  ErrorScene scene;
  const int at = scene.errors.add(10, true, scene.kalman);
  scene.errors.predict(scene.options.lasting_s, scene.kalman);
  EXPECT_NEAR(scene.variance(at), 0.04 * (1 - std::exp(-2)), 1e-12);
  for (int k = 0; k < 20; ++k) scene.errors.predict(1, scene.kalman);
  EXPECT_NEAR(scene.variance(at), 0.04, 1e-6);
}

TEST(MatchErrors, LandmarksOutOfViewGiveTheirPlacesFree) {
  ErrorScene scene;
  const int count = MatchErrors::places(scene.options, {});
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
