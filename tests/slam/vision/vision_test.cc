#include "slam/vision/vision.h"

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
      landmarks.push_back(*initialize_landmark(image, {}, Stamp(0), *corner, camera, options, kalman));
    }
    // Since then, the camera has rotated by an unknown angle of 0.01 rad (1 sigma).
    RobotMatrix Q = RobotMatrix::Zero();
    const Matrix43d dq = small_rotation_jacobian(kalman.state().orientation());
    Q.block<4, 4>(kOrientation, kOrientation) = 1e-4 * dq * dq.transpose();
    kalman.predict(kalman.state().robot(), RobotMatrix::Identity(), Q);
  }
  const VisionResult& update(const cv::Mat& now) { return vision.update(now, Stamp(0), landmarks, kalman); }

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
  ASSERT_TRUE(result.gate && result.update);
  EXPECT_EQ(result.gate->dof, 16);
  EXPECT_LT(result.gate->value, result.update->value);  // the gate assumes more noise than the update
  for (std::size_t i = 0; i < 8; ++i) {
    ASSERT_TRUE(result.searched[i].match && result.searched[i].used);
    const Landmark& landmark = scene.landmarks[result.searched_indices[i]];
    EXPECT_LT((*result.searched[i].match - landmark.pixel_first).norm(), 0.05);
  }
  EXPECT_LT(scene.kalman.state().marginal<4>(kOrientation).trace(), 0.1 * before);
}

TEST(Vision, AMatchThatContradictsTheOthersIsNotAnInlier) {
  Scene scene;
  const Eigen::Vector2i at = scene.landmarks[3].pixel_first.cast<int>();
  const auto around = [&](int shift) { return cv::Rect(at.x() - 9 + shift, at.y() - 9, 18, 18); };
  cv::Mat changed = scene.image.clone();
  scene.image(around(0)).copyTo(changed(around(4)));
  const VisionResult& result = scene.update(changed);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_EQ(result.searched[i].used, result.searched_indices[i] != 3) << result.searched_indices[i];
  EXPECT_EQ(result.matches, 8);
  EXPECT_EQ(result.inliers.size(), 7u);
}

TEST(Vision, MeasuresAtMostAsManyLandmarksAsTheOptionsAndTheirBoundAllow) {
  for (const auto& [wanted, bound, measured] : {std::tuple{3, 100, 3U}, {1000, 5, 5U}}) {
    Scene scene;
    scene.options.vision.measured_landmarks = wanted;
    scene.options.bounds.measured = bound;
    Vision vision(scene.options.vision, scene.options.bounds, scene.camera);
    const VisionResult& result = vision.update(scene.image, Stamp(0), scene.landmarks, scene.kalman);
    EXPECT_EQ(result.visible.size(), 8u);
    EXPECT_EQ(result.searched.size(), measured);
  }
}

TEST(Vision, LandmarksThatFailFromThisViewAreIgnoredButTwoAreRetriedLater) {
  Scene scene;
  scene.options.vision.measured_landmarks = 4;
  Vision vision(scene.options.vision, scene.options.bounds, scene.camera);
  for (std::size_t i = 0; i < 5; ++i) {
    scene.landmarks[i].misses = Landmark::kMostMisses;
    scene.landmarks[i].p_WC_missed = scene.kalman.state().position();
  }
  for (const auto& [t, retried] : {std::pair{Stamp(0), 0}, {Stamp(1'000'000'000), 2}}) {
    const VisionResult& result = vision.update(scene.image, t, scene.landmarks, scene.kalman);
    EXPECT_EQ(result.visible_indices, (std::vector<std::size_t>{5, 6, 7}));
    EXPECT_EQ(result.tested, 4U);
    const auto& all = result.searched_indices;
    EXPECT_EQ(all.size(), retried == 0 ? 3U : 4U);
    EXPECT_EQ(std::count_if(all.begin(), all.end(), [](std::size_t i) { return i < 5; }), retried);
  }
}

TEST(Vision, TheBiasOfAMatchIsAlwaysAStateEvenIfLandmarksOutnumberPlaces) {
  Scene scene;
  scene.options.vision.measured_landmarks = 1;
  ASSERT_LT(MatchBiases::places(scene.options.vision, scene.options.bounds), 8);
  Vision vision(scene.options.vision, scene.options.bounds, scene.camera);
  for (std::size_t i = 0; i < 8; ++i) scene.landmarks[i].id = static_cast<int>(i);
  std::set<int> placed;
  for (int k = 1; k <= 8; ++k) {
    const VisionResult& result = vision.update(scene.image, Stamp(k), scene.landmarks, scene.kalman);
    ASSERT_EQ(result.inliers.size(), 1U);
    Landmark& searched = scene.landmarks[result.searched_indices[0]];
    searched.last_search = Stamp(k);
    EXPECT_GE(vision.biases().at(searched.id), kRobot);
    placed.insert(searched.id);
  }
  EXPECT_EQ(placed.size(), 8U);  // their unknown bias makes landmarks without a place the most informative
}

TEST(Vision, WithoutMatchesTheStateIsUnchanged) {
  Scene scene;
  const Eigen::MatrixXd P = scene.kalman.state().P();
  const VisionResult& result = scene.update(cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)));
  EXPECT_EQ(result.searched.size(), 8u);
  EXPECT_EQ(result.matches, 0);
  EXPECT_FALSE(result.updated || result.gate || result.update);
  EXPECT_EQ(scene.kalman.state().P(), P);
}

/// `good` matches that are explained by a common shift of the robot, followed by `bad` ones that are not.
StackedMeasurement matches(int good, int bad) {
  std::mt19937_64 random(7);
  const auto number = [&] { return 2 * static_cast<double>(random() >> 11) * 0x1p-53 - 1; };
  const auto noise = [&] {  // one by one, as compilers evaluate arguments in different orders
    const double y = number(), x = number();
    return Eigen::Vector2d(x, y);
  };
  const int count = good + bad;
  StackedMeasurement stacked;
  stacked.resize(kRobot, 2 * count);
  stacked.PHt().setZero();
  for (int i = 0; i <= count; ++i) stacked.first_row.push_back(2 * i);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) stacked.S().block<2, 2>(2 * i, 2 * j) = 25 * Eigen::Matrix2d::Identity();
    stacked.S().block<2, 2>(2 * i, 2 * i) += 0.04 * Eigen::Matrix2d::Identity();
    stacked.innovation().segment<2>(2 * i) = Eigen::Vector2d(6, -4) + 0.1 * noise();
    if (i >= good) stacked.innovation().segment<2>(2 * i) = 8 * noise();
  }
  return stacked;
}

TEST(Consensus, KeepsTheMatchesThatOneMotionExplainsAndDropsTheRest) {
  Consensus consensus;
  EXPECT_EQ(consensus.largest(matches(8, 5), 9.21), (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(Consensus, PrunesTheMatchesThatTheOthersContradict) {
  std::vector<std::size_t> inliers{0, 1, 2, 3, 4, 5, 8, 9, 10};
  Consensus().prune(matches(8, 5), 9.21, inliers);
  EXPECT_EQ(inliers, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5}));
}

struct ErrorScene {
  ErrorScene() {
    for (int id = 10; Landmark & landmark : landmarks) landmark.id = id++;
  }
  double variance(int at) const { return kalman.state().storage_P(at, at); }

  Options::Vision options{.measured_landmarks = 2};
  Kalman kalman{{RobotVector::Zero(), RobotMatrix::Identity()}, false, MatchBiases::places(options, {})};
  MatchBiases biases{options, {}};
  std::vector<Landmark> landmarks = std::vector<Landmark>(9);
};

TEST(MatchBiases, StartAtZeroAndGrowToTheVarianceThatTheyHaveAfterALoss) {
  ErrorScene scene;
  const int fresh = scene.biases.add(10, true, scene.kalman),
            again = scene.biases.add(11, false, scene.kalman);
  EXPECT_EQ(scene.biases.at(10), fresh);
  EXPECT_EQ(scene.biases.at(12), -1);
  EXPECT_EQ(scene.variance(fresh), 0);
  EXPECT_NEAR(scene.variance(again), 0.04, 1e-15);
  scene.biases.predict(scene.options.match_bias_s, scene.kalman);
  EXPECT_NEAR(scene.variance(fresh), 0.04 * (1 - std::exp(-2)), 1e-12);
  for (int k = 0; k < 20; ++k) scene.biases.predict(1, scene.kalman);
  EXPECT_NEAR(scene.variance(fresh), 0.04, 1e-6);
}

TEST(MatchBiases, LandmarksOutOfViewGiveTheirPlacesFreeWhichOptionsWithoutBiasDoNotHave) {
  ErrorScene scene;
  Options::Vision without = scene.options, blind = scene.options;
  without.match_bias_sigma_px = 0, blind.enabled = false;
  EXPECT_EQ(MatchBiases::places(without, {}) + MatchBiases::places(blind, {}), 0);
  const int count = MatchBiases::places(scene.options, {});
  for (int id = 10; id < 10 + count; ++id) EXPECT_GE(scene.biases.add(id, false, scene.kalman), kRobot);
  EXPECT_EQ(scene.biases.add(99, false, scene.kalman), -1);
  scene.biases.keep_visible({0, 2}, scene.landmarks, scene.kalman);
  EXPECT_GE(scene.biases.at(10), kRobot);
  EXPECT_EQ(scene.biases.at(11), -1);
  EXPECT_EQ(scene.variance(kRobot + 2), 0);
  EXPECT_GE(scene.biases.add(99, false, scene.kalman), kRobot);
  scene.biases.clear(scene.kalman);
  EXPECT_EQ(scene.biases.at(10), -1);
  EXPECT_EQ(scene.variance(kRobot), 0);
}

}  // namespace
}  // namespace slam
