#include "slam/vision/vision.h"

#include <gtest/gtest.h>

#include "slam/vision/corner_detector.h"
#include "slam/vision/map.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

/// A camera that looks along +x, and landmarks initialized at corners of its image.
struct Scene {
  Scene() {
    std::mt19937_64 random(1);
    std::vector<Eigen::Vector2d> occupied;
    while (landmarks.size() < 8) {
      const auto corner = propose_corner(image, occupied, options.vision, random);
      if (!corner) continue;
      occupied.push_back(corner->cast<double>());
      landmarks.push_back(*initialize_landmark(image, Stamp(0), *corner, camera, options, kalman));
    }
    // since then the camera has rotated by an unknown angle of 0.01 rad (1 sigma)
    RobotMatrix Q = RobotMatrix::Zero();
    const Matrix43d dq = small_rotation_jacobian(kalman.state().orientation());
    Q.block<4, 4>(kOrientation, kOrientation) = 1e-4 * dq * dq.transpose();
    kalman.predict(kalman.state().robot(), RobotMatrix::Identity(), Q);
  }
  const VisionResult& update(const cv::Mat& now) { return vision.update(now, landmarks, kalman); }

  Options options;
  Camera camera{CameraIntrinsics{}};
  cv::Mat image = random_blocks(320, 8, 5);
  Kalman kalman{{looking_ahead(), 1e-8 * RobotMatrix::Identity()},
                false,
                MatchBiases::places(options.vision, options.bounds)};
  std::vector<Landmark> landmarks;
  Vision vision{options.vision, options.bounds, camera};
};

TEST(Vision, FindsTheLandmarksOfAnUnchangedViewAndReducesTheUncertainty) {
  Scene scene;
  const double before = scene.kalman.state().marginal<4>(kOrientation).trace();
  const VisionResult& result = scene.update(scene.image);
  EXPECT_EQ(result.visible.size(), 8u);
  ASSERT_EQ(result.searched.size(), 8u);
  EXPECT_EQ(result.matches, 8);
  EXPECT_EQ(result.inliers.size(), 8u);
  EXPECT_TRUE(result.updated);
  Eigen::AlignedBox2d box;
  for (const Landmark& landmark : scene.landmarks) box.extend(landmark.pixel_first);
  EXPECT_NEAR(result.coverage, box.volume() / (320 * 240), 0.001);
  ASSERT_TRUE(result.nis && result.update_nis);
  EXPECT_EQ(result.nis->dof, 16);
  EXPECT_GT(result.nis->value, result.update_nis->value);  // the gate assumes less noise than the update
  for (const SearchedLandmark& s : result.searched) {
    ASSERT_TRUE(s.match && s.inlier);
    EXPECT_LT((*s.match - scene.landmarks[s.index].pixel_first).norm(), 0.05);
  }
  EXPECT_LT(scene.kalman.state().marginal<4>(kOrientation).trace(), 0.1 * before);
}

TEST(Vision, AMatchThatContradictsTheOthersIsNoInlier) {
  Scene scene;
  const Eigen::Vector2i at = scene.landmarks[3].pixel_first.cast<int>();
  const auto around = [&](int shift) { return cv::Rect(at.x() - 9 + shift, at.y() - 9, 18, 18); };
  cv::Mat changed = scene.image.clone();
  scene.image(around(0)).copyTo(changed(around(4)));
  const VisionResult& result = scene.update(changed);
  for (const SearchedLandmark& s : result.searched) EXPECT_EQ(s.inlier, s.index != 3) << s.index;
  EXPECT_EQ(result.matches, 8);
  EXPECT_EQ(result.inliers.size(), 7u);
}

TEST(Vision, MeasuresAtMostAsManyLandmarksAsTheOptionsSay) {
  Scene scene;
  scene.options.vision.measured_landmarks = 3;
  Vision vision(scene.options.vision, scene.options.bounds, scene.camera);
  const VisionResult& result = vision.update(scene.image, scene.landmarks, scene.kalman);
  EXPECT_EQ(result.visible.size(), 8u);
  EXPECT_EQ(result.searched.size(), 3u);
}

TEST(Vision, MeasuresNoMoreLandmarksThanTheBoundHoweverManyTheOptionsWant) {
  Scene scene;
  scene.options.vision.measured_landmarks = 1000;
  scene.options.bounds.measured = 5;
  Vision vision(scene.options.vision, scene.options.bounds, scene.camera);
  EXPECT_EQ(vision.update(scene.image, scene.landmarks, scene.kalman).searched.size(), 5u);
}

TEST(Vision, WithoutMatchesTheStateStaysAsItIs) {
  Scene scene;
  const Eigen::MatrixXd P = scene.kalman.state().P();
  const VisionResult& result = scene.update(cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)));
  EXPECT_EQ(result.searched.size(), 8u);
  EXPECT_EQ(result.matches, 0);
  EXPECT_FALSE(result.updated || result.nis || result.update_nis);
  EXPECT_EQ(scene.kalman.state().P(), P);
}

}  // namespace
}  // namespace slam
