#include "slam/vision/map.h"

#include "slam/vision/active_search.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

const Eigen::Vector2i kPixel(200, 90);

/// A camera that looks along +x.
struct Scene {
  std::optional<Landmark> initialize(const Eigen::Vector2i& pixel) {
    return initialize_landmark(image, depth, Stamp(7), pixel, camera, options, kalman);
  }
  /// The point 4 m ahead of the camera that it sees at a pixel.
  Eigen::Vector3d seen_at(const Eigen::Vector2d& pixel) const {
    return kalman.state().X_WC() * (4 * camera.unproject(pixel)->h);
  }
  Options options;
  Camera camera{CameraIntrinsics{}};
  cv::Mat image = random_blocks(320, 8, 5);
  DepthImage depth;
  Kalman kalman{{looking_ahead(), 1e-6 * RobotMatrix::Identity()}, false};
};

TEST(LandmarkInitialization, ANewLandmarkOfEitherKindIsPredictedWhereItWasSeen) {
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

TEST(LandmarkInitialization, AMeasuredDepthPlacesALandmarkIfThereIsOneAndTheOptionsRequestIt) {
  Scene scene;
  scene.depth = {cv::Mat(240, 320, CV_16UC1, cv::Scalar(2500)), 0.01};
  scene.depth.mm.at<unsigned short>(50, 40) = 0;
  const Options::Depth& unmeasured = scene.options.depth;
  const auto rho_of = [&](const Eigen::Vector2i& pixel) {
    const int at = scene.initialize(pixel)->at + 5;
    return Eigen::Vector2d(scene.kalman.state().storage_x(at),
                           std::sqrt(scene.kalman.state().storage_P(at, at)));
  };
  const Eigen::Vector2d prior(unmeasured.inverse_1_m, unmeasured.sigma_inverse_1_m);
  EXPECT_LT((rho_of(kPixel) - prior).norm(), 1e-12);
  scene.options.depth.first_sight = FirstSight::measured_depth;
  EXPECT_LT((rho_of({40, 50}) - prior).norm(), 1e-12);
  const auto landmark = scene.initialize(kPixel);
  const State& state = scene.kalman.state();
  const Eigen::Vector3d p_C = state.X_WC().inverse() * position(landmark->kind, landmark->parameters(state));
  EXPECT_NEAR(p_C.z(), 2.5, 1e-9);
  const Eigen::Matrix3d P_C =
      state.X_WC().linear().transpose() * position_covariance(state, *landmark) * state.X_WC().linear();
  EXPECT_NEAR(std::sqrt(P_C(2, 2)), 2.5 * 2.5 * 0.01, 0.002);
}

TEST(DepthImage, HasTheDepthOfAPlanarPatchButNoneAcrossAnEdgeOrAHole) {
  DepthImage image{cv::Mat(40, 40, CV_16UC1), 0.005};
  for (int v = 0; v < 40; ++v)
    for (int u = 0; u < 40; ++u)
      image.mm.at<unsigned short>(v, u) =
          static_cast<unsigned short>(std::lround(1e3 / (0.4 + 0.003 * u - 0.002 * v)));
  const auto slanted = image.at({20, 15});
  ASSERT_TRUE(slanted);
  EXPECT_NEAR(slanted->inverse_1_m, 0.43, 1e-4);
  EXPECT_EQ(slanted->sigma_1_m, 0.005);
  image.mm.at<unsigned short>(20, 25) = 0;
  EXPECT_FALSE(image.at({20, 15}));
  EXPECT_TRUE(image.at({20, 14}));
  image.mm.colRange(24, 40) = cv::Scalar(8000);
  EXPECT_FALSE(image.at({20, 14}));
  EXPECT_TRUE(image.at({18, 14}));
  EXPECT_FALSE(DepthImage{}.at({20, 15}));
}

TEST(LandmarkInitialization, APixelWithoutARayGivesNothingAndLeavesTheStateUnchanged) {
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

using namespace std::chrono_literals;

Options options_for(int landmarks) {
  Options options;
  options.vision.visible_landmarks = landmarks;
  options.vision.viewpoint_sigma_px = 0.5;
  return options;
}

/// A map with `count` new landmarks.
struct Initialized {
  explicit Initialized(int count) : Initialized(options_for(count)) {}
  explicit Initialized(const Options& options) : camera(CameraIntrinsics{}), map(options, camera, 1) {
    map.initialize(image, {}, Stamp(7), {}, kalman, removed);
  }
  /// sigmas: deviation of the match from its predicted pixel.
  void search(std::size_t i, bool success, const Eigen::Vector2d& sigmas = Eigen::Vector2d::Zero()) {
    const Search search{.pixel = pixel(i),
                        .S = 0.25 * Eigen::Matrix2d::Identity(),
                        .used = success,
                        .match = pixel(i) + 0.5 * sigmas};
    map.record_search(i, search, true, Stamp(8), kalman);
  }
  std::vector<int> pruned() {
    std::vector<int> deleted;
    map.prune(kalman, deleted);
    return deleted;
  }
  cv::Mat image = random_blocks(320, 8, 5);
  std::vector<int> removed;
  Camera camera;
  Kalman kalman{{looking_ahead({0.3, -0.2, 1.4}), 1e-4 * RobotMatrix::Identity()}, true};
  Map map;

  std::size_t size() const { return map.landmarks().size(); }
  Vector6d parameters(std::size_t i) const {
    return kalman.state().storage_x.segment<6>(map.landmarks()[i].at);
  }
  Eigen::MatrixXd covariance(std::size_t i) const {
    const Landmark& landmark = map.landmarks()[i];
    return kalman.state().P().block(landmark.at, landmark.at, landmark.size(), landmark.size());
  }
  /// The position of a landmark, m in C.
  Eigen::Vector3d p_C(std::size_t i) const {
    const Landmark& landmark = map.landmarks()[i];
    return kalman.state().X_WC().inverse() * position(landmark.kind, landmark.parameters(kalman.state()));
  }
  double distance(std::size_t i) const { return p_C(i).norm(); }
  Eigen::Vector2d pixel(std::size_t i) const { return camera.project(p_C(i))->pixel; }
  std::vector<Eigen::Vector2d> pixels() const {
    std::vector<Eigen::Vector2d> all;
    for (std::size_t i = 0; i < size(); ++i) all.push_back(pixel(i));
    return all;
  }
  /// Makes the inverse depth of a landmark precise, as after many views from many places.
  void know_depth(std::size_t i, double value, double variance = 1e-8) {
    Measurement m(1);
    m.H_landmark = Eigen::RowVectorXd::Unit(6, 5);
    m.landmark_at = map.landmarks()[i].at;
    m.R(0, 0) = variance;
    m.innovation(0) = value - parameters(i)(5);
    StackedMeasurement stacked;
    stack(kalman.state(), {m}, stacked);
    ASSERT_TRUE(kalman.update(stacked));
  }
  /// Moves the camera; nothing else changes.
  void move(const Eigen::Vector3d& by) {
    RobotVector x = kalman.state().robot();
    x.segment<3>(kPosition) += by;
    kalman.predict(x, RobotMatrix::Identity(), RobotMatrix::Zero());
  }
};

TEST(Map, InitializesAsManyLandmarksAsWantedAwayFromEachOtherAndFromVisibleOnes) {
  Initialized b(8);
  ASSERT_EQ(b.size(), 8u);
  ASSERT_EQ(b.kalman.state().size, kRobot + 48);
  b.map.initialize(b.image, {}, Stamp(8), b.pixels(), b.kalman, b.removed);
  EXPECT_EQ(b.size(), 8u);  // none is missing
  const std::vector<Eigen::Vector2d> two{b.pixel(0), b.pixel(1)};
  b.map.initialize(b.image, {}, Stamp(8), two, b.kalman, b.removed);
  EXPECT_EQ(b.size(), 11u);  // three per frame
  const std::vector<Eigen::Vector2d> all = b.pixels();
  for (std::size_t i = 0; i < 11; ++i)
    for (std::size_t j = 0; j < (i < 8 ? i : 2); ++j)
      EXPECT_GE((all[i] - all[j]).norm(), 20 - 1e-9) << i << ' ' << j;
}

TEST(Map, InitializesNothingInAnImageWithoutCorners) {
  Initialized b(8);
  const cv::Mat flat(240, 320, CV_8UC1, cv::Scalar(128));
  const InitializationCount count = b.map.initialize(flat, {}, Stamp(8), {}, b.kalman, b.removed);
  EXPECT_EQ(count.wanted, 3);
  EXPECT_EQ(count.added, 0);
  EXPECT_EQ(b.size(), 8u);
}

TEST(Map, WeakCornersAreUsedIfFewLandmarksAreVisibleAndNoStrongOneIsFound) {
  Initialized b(8);
  const cv::Mat weak = 128 + 0.15 * random_blocks(320, 8, 5);
  ASSERT_FALSE(strongest_corner(weak, {0, 0, 320, 240}, Options::Vision::corner_threshold));
  std::vector<Eigen::Vector2d> four = b.pixels();
  four.resize(4);
  const auto added = [&](const std::vector<Eigen::Vector2d>& visible) {
    return b.map.initialize(weak, {}, Stamp(8), visible, b.kalman, b.removed).added;
  };
  for (int frame = 0; frame < 60; ++frame) ASSERT_EQ(added(four), 0) << frame;
  EXPECT_EQ(added({}), 0) << "they are not the first choice";
  int all = 0;
  for (int frame = 0; frame < 30; ++frame) all += added({});
  EXPECT_GT(all, 3);
  EXPECT_EQ(added(four), 0);
}

TEST(Map, ALandmarkThatSlidesIsDeletedAndItsPlaceIsLeftOut) {
  Initialized b(8);
  const Eigen::Vector2d place = b.pixel(0);
  for (int k = 0; k < 40; ++k) {
    b.search(0, true, {0, 0.6});
    b.search(1, true, {0, k % 2 ? 3 : -3});
    b.search(2, true, {0.3, 0});
    if (k == 10) EXPECT_EQ(b.pruned(), std::vector<int>{});
  }
  EXPECT_EQ(b.pruned(), std::vector<int>{0});
  for (int k = 0; k < 20; ++k) b.map.initialize(b.image, {}, Stamp(8), b.pixels(), b.kalman, b.removed);
  EXPECT_EQ(b.size(), 8u);
  for (const Eigen::Vector2d& pixel : b.pixels()) EXPECT_GE((pixel - place).norm(), 20 - 1e-9);
}

TEST(Map, LinesAreInitializedOneAtATimeAndOnlyWhileTheCameraMoves) {
  Options options;
  options.depth.first_sight = FirstSight::particles;
  Initialized b(options);
  EXPECT_EQ(b.size(), 0u);
  RobotVector x = b.kalman.state().robot();
  x(kVelocity) = 0.2;
  b.kalman.predict(x, RobotMatrix::Identity(), RobotMatrix::Zero());
  for (int k = 0; k < 2; ++k) b.map.initialize(b.image, {}, Stamp(8), {}, b.kalman, b.removed);
  EXPECT_EQ(b.size(), 1u);
}

TEST(Map, ALineWithoutMatchesOrWithoutDepthAfterTenAttemptsIsDeletedAndItsDepthsAreReported) {
  Options options;
  options.depth.first_sight = FirstSight::particles;
  options.depth.particles.minimum_speed_m_s = -1;
  Initialized b(options), standing(options);
  ASSERT_EQ(b.size(), 1u);
  std::vector<int> deleted;
  std::vector<DepthHypotheses> lines;
  b.map.search_lines(cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)), b.kalman, deleted, lines);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(lines[0].particles.empty());
  EXPECT_EQ(deleted, std::vector<int>{0});
  EXPECT_EQ(b.kalman.state().size, kRobot);
  for (std::size_t k = 1; k <= 11; ++k) {
    standing.map.search_lines(standing.image, standing.kalman, deleted, lines);
    EXPECT_EQ(standing.size(), k <= 10 ? 1u : 0u) << k;
  }
}

TEST(Map, KnownLandmarksAreInitializedOnceAndAnUnseenOneIsReported) {
  Options options = options_for(0);
  options.known_landmarks.at_m = {{-5, 0, 1.4}};  // behind the camera
  Initialized b(options);
  EXPECT_FALSE(b.map.initialize_known(b.image, Stamp(7), b.kalman));
  EXPECT_TRUE(b.map.initialize_known(b.image, Stamp(8), b.kalman));
  EXPECT_EQ(b.size(), 0u);
}

TEST(Map, NeverExceedsItsBoundAndReplacesOutOfViewLandmarksFoundLeastOften) {
  Options options = options_for(8);
  options.bounds.landmarks = 5;
  Initialized b(options);
  ASSERT_EQ(b.size(), 5u);
  b.map.initialize(b.image, {}, Stamp(7), {}, b.kalman, b.removed);
  EXPECT_TRUE(b.removed.empty());  // all are in view
  for (const std::size_t i : {0, 1, 4, 0}) b.search(i, true);
  for (const std::size_t i : {1, 2}) b.map.record_visible(i, Stamp(9));
  b.map.initialize(b.image, {}, Stamp(9), {}, b.kalman, b.removed);
  EXPECT_EQ(b.removed, (std::vector<int>{3, 4, 0}));  // 1 and 2 are in view
  EXPECT_EQ(b.size(), 5u);
  EXPECT_EQ(b.kalman.state().size, kRobot + 5 * InverseDepth::kSize);
}

TEST(Map, DeletesWhatIsBehindOrWasFoundLessThanEverySecondTimeBeforeItWasSetAsideAndNothingElse) {
  Initialized b(5);
  const auto search = [&](std::size_t i, int attempts, int successes) {
    for (int k = 0; k < attempts; ++k) b.search(i, k < successes);
  };
  search(0, 4, 0);         // not yet searched for often enough
  search(1, 10, 5);        // just good enough
  search(2, 9, 4);         // not
  search(3, 40, 19);       // while it is set aside, failures do not count
  b.know_depth(4, -0.01);  // certainly behind the camera that first saw it
  EXPECT_EQ(b.pruned(), (std::vector<int>{4, 2}));
  EXPECT_EQ(b.size(), 3u);
}

TEST(Map, ALandmarkIsSetAsideAfterRepeatedFailuresUntilItIsSeenFromElsewhereOrFound) {
  Initialized b(1);
  b.know_depth(0, 0.25);
  const auto is_set_aside = [&] { return b.map.landmarks()[0].is_set_aside(b.kalman.state()); };
  for (int k = 0; k < 4; ++k) b.search(0, false);
  EXPECT_FALSE(is_set_aside());
  b.search(0, false);
  EXPECT_TRUE(is_set_aside());
  RobotVector x = b.kalman.state().robot();
  for (const double y_m : {0.8, 0.0}) {
    x(kPosition + 1) = y_m - 0.2;
    b.kalman.predict(x, RobotMatrix::Identity(), RobotMatrix::Zero());
    EXPECT_EQ(is_set_aside(), y_m == 0);
  }
  b.search(0, true);
  EXPECT_FALSE(is_set_aside());
}

TEST(Map, CountsLandmarksDeletedSoonAfterTheyWereFirstSeen) {
  Initialized b(4);
  for (std::size_t i = 0; const auto age : {1s, 9s, 10s}) {
    b.map.record_visible(i, b.map.landmarks()[i].initialized + age);
    for (int k = 0; k < 10; ++k) b.search(i, false);
    ++i;
  }
  std::vector<int> deleted;
  EXPECT_EQ(b.map.prune(b.kalman, deleted), 2u);
  EXPECT_EQ(deleted.size(), 3u);
}

TEST(Map, CountsDeletionsInOneDirectionOnlyOnceInFiveSeconds) {
  for (const double back_m : {0.0, 1000.0}) {
    Initialized b(3);
    b.move({-back_m, 0, 0});  // from far away all are in one direction
    for (std::size_t i = 3; const auto age : {1000ms, 4000ms, 9500ms}) {  // the last one is deleted first
      --i;
      b.map.record_visible(i, b.map.landmarks()[i].initialized + age);
      for (int k = 0; k < 10; ++k) b.search(i, false);
    }
    EXPECT_EQ(b.map.prune(b.kalman, b.removed), back_m > 0 ? 2u : 3u);
  }
}

TEST(Map, DeletingAndConvertingKeepTheParametersOfEveryOtherLandmark) {
  Initialized b(5);
  for (const std::size_t i : {1u, 3u}) b.know_depth(i, 0.25);
  const std::vector<Eigen::Vector2d> before = b.pixels();
  const auto view = predict_view(b.kalman, b.map.landmarks(), b.camera, 1);
  b.map.convert_to_points(Stamp(0), b.kalman);
  const auto view_of_points = predict_view(b.kalman, b.map.landmarks(), b.camera, 1);
  ASSERT_EQ(view.size() + view_of_points.size(), 10u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(std::holds_alternative<Point>(b.map.landmarks()[i].kind), i == 1 || i == 3) << i;
    EXPECT_LT((b.pixel(i) - before[i]).norm(), 1e-9) << i;
    // The heading is constrained again.
    EXPECT_LT((view_of_points[i].S - view[i].S).norm(), 1e-3 * view[i].S.norm()) << i;
  }
  for (int k = 0; k < 10; ++k) b.search(1, false);
  ASSERT_EQ(b.pruned().size(), 1u);
  EXPECT_EQ(b.kalman.state().size, kRobot + 6 + 6 + 3 + 6);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_LT((b.pixel(i) - before[i + 1]).norm(), 1e-9) << i;
}

TEST(Map, ALandmarkIsLessCertainAfterItsViewHasChangedButNotAfterSwaying) {
  Initialized b(1);
  const Eigen::MatrixXd before = b.covariance(0);
  const double distance = b.distance(0);
  const Eigen::Vector3d aside(0, 0.01 * distance, 0);
  b.move(aside);
  b.map.inflate_for_view_change(0, b.kalman);
  b.move(-aside);
  b.map.inflate_for_view_change(0, b.kalman);
  EXPECT_EQ(b.covariance(0), before);
  b.move(Eigen::Vector3d(0, 0.04 * distance, 0));
  b.map.inflate_for_view_change(0, b.kalman);
  b.map.inflate_for_view_change(0, b.kalman);  // once for the same view
  Eigen::MatrixXd more = b.covariance(0) - before;
  const double angle = 0.5 / b.camera.intrinsics().fu_px;
  EXPECT_NEAR(more(3, 3), 0.04 * angle * angle, 0.002 * angle * angle);  // the distance has changed as well
  EXPECT_NEAR(more(4, 4), more(3, 3), 1e-15);
  more(3, 3) = more(4, 4) = 0;
  EXPECT_LT(more.norm(), 1e-15);
}

/// Moves the camera 1 m aside at t, which is another place, and back 11 s later.
void leave_and_return(Initialized& b, Stamp t) {
  const Eigen::Vector3d aside(0, 1, 0);
  b.move(aside);
  b.map.consider_known(t, b.kalman);
  b.move(-aside);
  b.map.consider_known(t + 11s, b.kalman);
}

TEST(Map, InAPlaceSeenBeforeOnlyLandmarksInitializedSinceAreUpdated) {
  Initialized b(2);
  const auto considered = [&](std::size_t i) { return b.kalman.considers(b.map.landmarks()[i].at); };
  b.map.consider_known(1s, b.kalman);
  b.map.consider_known(9s, b.kalman);
  b.map.consider_known(18s, b.kalman);  // the same visit
  EXPECT_FALSE(considered(0));
  b.map.initialize(b.image, {}, 20s, {}, b.kalman, b.removed);
  ASSERT_EQ(b.size(), 4u);
  leave_and_return(b, 21s);
  EXPECT_TRUE(considered(0) && considered(1));
  EXPECT_FALSE(considered(2) || considered(3));
  b.move({0.1, 0, 0});
  b.map.consider_known(33s, b.kalman);  // still the same place
  EXPECT_TRUE(considered(1));
  leave_and_return(b, 34s);
  EXPECT_TRUE(considered(3));
  Options white = options_for(1);
  white.vision.match_bias_sigma_px = 0;
  Initialized c(white);
  c.map.consider_known(1s, c.kalman);
  leave_and_return(c, 2s);
  EXPECT_FALSE(c.kalman.considers(c.map.landmarks()[0].at));
}

TEST(Map, AConsideredLandmarkIsInflatedOnTheSecondVisitOnly) {
  Initialized b(1);
  b.map.consider_known(1s, b.kalman);
  for (const Stamp t : {2s, 14s}) {
    leave_and_return(b, t);
    const Eigen::MatrixXd before = b.covariance(0);
    b.move(Eigen::Vector3d(0, t == 2s ? 0.14 : -0.14, 0));
    b.map.inflate_for_view_change(0, b.kalman);
    EXPECT_EQ(b.covariance(0)(3, 3) > before(3, 3), t == 2s);
  }
}

TEST(Map, LandmarksOutOfViewBecomePointsAtALargerUncertainty) {
  Initialized b(2);
  // The linearity index 4 σ / (ρ² d) is 0.08, between the bound in view, 0.05, and twice that bound.
  for (const std::size_t i : {0u, 1u}) b.know_depth(i, 0.25, 0.005 * 0.005);
  b.map.record_visible(1, 1s);
  b.map.convert_to_points(1s, b.kalman);
  EXPECT_TRUE(std::holds_alternative<Point>(b.map.landmarks()[0].kind));
  EXPECT_FALSE(std::holds_alternative<Point>(b.map.landmarks()[1].kind));
}

TEST(Map, APointIsInflatedIsotropically) {
  Initialized b(1);
  b.know_depth(0, 0.5);
  b.map.convert_to_points(Stamp(0), b.kalman);
  const Eigen::MatrixXd before = b.covariance(0);
  b.move(Eigen::Vector3d(0.2, 0, 0));
  b.map.inflate_for_view_change(0, b.kalman);
  const Eigen::MatrixXd more = b.covariance(0) - before;
  EXPECT_LT((more - more(0, 0) * Eigen::Matrix3d::Identity()).norm(), 1e-12 * more(0, 0) + 1e-18);
  const double sigma = 0.5 / b.camera.intrinsics().fu_px * b.distance(0);
  EXPECT_NEAR(more(0, 0), sigma * sigma * 0.2 / b.distance(0), 1e-3 * more(0, 0));
}

}  // namespace
}  // namespace slam
