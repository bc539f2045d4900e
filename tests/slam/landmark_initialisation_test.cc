#include "slam/vision/map.h"

#include <gtest/gtest.h>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

const Eigen::Vector2i kPixel(200, 90);

/// A camera that looks along +x.
struct Scene {
  std::optional<Landmark> initialize(const Eigen::Vector2i& pixel) {
    return initialize_landmark(image, Stamp(7), pixel, camera, options, kalman);
  }
  /// The point 4 m ahead of the camera that it sees at a pixel.
  Eigen::Vector3d seen_at(const Eigen::Vector2d& pixel) const {
    return kalman.state().X_WC() * (4 * camera.unproject(pixel)->h);
  }
  Options options;
  Camera camera{CameraIntrinsics{}};
  cv::Mat image = random_blocks(320, 8, 5);
  Kalman kalman{{looking_ahead(), 1e-6 * RobotMatrix::Identity()}, false};
};

TEST(LandmarkInitialization, ANewLandmarkIsPredictedWhereItWasSeenInBothKinds) {
  for (const FirstSight kind : {FirstSight::inverse_depth, FirstSight::particles}) {
    Scene scene;
    scene.options.depth.first_sight = kind;
    const auto landmark = scene.initialize(kPixel);
    ASSERT_TRUE(landmark);
    const State& state = scene.kalman.state();
    EXPECT_EQ(state.size, kRobot + 6);
    EXPECT_EQ(std::holds_alternative<SemiInfiniteLine>(landmark->kind), kind == FirstSight::particles);
    EXPECT_EQ(landmark->initialized, Stamp(7));
    EXPECT_EQ(landmark->X_WC_first.matrix(), state.X_WC().matrix());
    EXPECT_EQ(landmark->patch.gray, cut_patch(scene.image, kPixel).gray);
    const Direction d =
        direction(landmark->kind, landmark->parameters(state), state.position(), state.orientation());
    EXPECT_LT((scene.camera.project(d.h_C)->pixel - kPixel.cast<double>()).norm(), 1e-9);
  }
}

TEST(LandmarkInitialization, TheBearingOfANewLandmarkIsAsCertainAsItsPixel) {
  Scene exact, rough;
  exact.options.vision.sigma_first_px = 0;
  rough.options.vision.sigma_first_px = 1;
  const int at = exact.initialize(kPixel)->at + 4;
  rough.initialize(kPixel);
  const double more = rough.kalman.state().P()(at, at) - exact.kalman.state().P()(at, at);
  const double sigma = rough.camera.sigma(kPixel.cast<double>(), 1) / rough.camera.intrinsics().fu_px;
  EXPECT_GT(more, 0.2 * sigma * sigma);  // a pixel spans a smaller angle away from the center
  EXPECT_LT(more, 1.5 * sigma * sigma);
}

TEST(LandmarkInitialization, APixelWithoutRayGivesNothingAndLeavesTheState) {
  Scene scene;
  CameraIntrinsics narrow;
  narrow.lens = OneParameterRadial{1e-4};  // its image circle has a radius of 71 px
  scene.camera = Camera(narrow);
  EXPECT_FALSE(scene.initialize({300, 120}));
  EXPECT_EQ(scene.kalman.state().size, kRobot);
}

TEST(LandmarkInitialization, AKnownLandmarkIsAPointWhoseCornerIsSeen) {
  Scene scene;
  scene.image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(60));
  scene.image(cv::Rect(160, 120, 160, 120)).setTo(cv::Scalar(200));  // its corner is at (159.5, 119.5)
  const auto landmark = initialize_known_landmark(scene.image, Stamp(7), scene.seen_at({160, 120}),
                                                  scene.camera, scene.options, scene.kalman);
  ASSERT_TRUE(landmark);
  EXPECT_TRUE(std::holds_alternative<Point>(landmark->kind));
  EXPECT_LT((landmark->pixel_first - Eigen::Vector2d(159.5, 119.5)).norm(), 0.1);
  EXPECT_EQ(scene.kalman.state().size, kRobot + 3);
  EXPECT_FALSE(initialize_known_landmark(scene.image, Stamp(7), scene.seen_at({60, 60}), scene.camera,
                                         scene.options, scene.kalman));  // a flat part of the image
  EXPECT_EQ(scene.kalman.state().size, kRobot + 3);
}

}  // namespace
}  // namespace slam
