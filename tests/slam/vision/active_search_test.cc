#include "slam/vision/active_search.h"

#include <opencv2/imgproc.hpp>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

/// Smoothed noise in which no two places are alike.
cv::Mat picture() {
  cv::Mat smooth;
  cv::GaussianBlur(random_blocks(320, 1, 3), smooth, cv::Size(0, 0), 2);
  cv::normalize(smooth, smooth, 0, 255, cv::NORM_MINMAX);
  return smooth;
}

/// A camera that looks along +x, its landmark 4 m away at `pixel`, and the estimated turn of the
/// camera.
struct Scene {
  explicit Scene(const Eigen::Vector2i& pixel, double turned = 0, double sigma_turn = 0.01) {
    const RobotVector first = looking_ahead({0, 0, 0});
    Options::Depth depth;
    depth.inverse_1_m = 0.25;
    const Ray ray = camera.unproject(pixel.cast<double>()).value();
    Landmark& landmark = landmarks.emplace_back();
    landmark.X_WC_first = camera_pose(first);
    landmark.patch = cut_patch(image, pixel);
    landmark.at = kalman.append(initialize_inverse_depth(first, ray, 0.1, {0, 0}, depth));
    RobotState now{first, RobotMatrix::Zero()};
    now.x.segment<4>(kOrientation) =
        quaternion_product(quaternion_exp({0, 0, turned}), first.segment<4>(kOrientation));
    const Matrix43d dq = small_rotation_jacobian(now.x.segment<4>(kOrientation));
    now.P.block<4, 4>(kOrientation, kOrientation) = sigma_turn * sigma_turn * dq * dq.transpose();
    kalman.reset_robot(now);
  }
  std::vector<Candidate> view() const { return predict_view(kalman, landmarks, camera, 1); }

  cv::Mat image = picture();
  Camera camera{CameraIntrinsics{}};
  Kalman kalman{{looking_ahead({0, 0, 0}), RobotMatrix::Zero()}, false};
  std::vector<Landmark> landmarks;
};

TEST(ActiveSearch, PredictsALandmarkAtItsFirstPixelWithTheCovarianceOfPoseLandmarkAndPixel) {
  const Scene scene({157, 127}, 0, 0.02);  // at the center: a turn of θ moves the image by f θ
  const auto view = scene.view();
  ASSERT_EQ(view.size(), 1u);
  EXPECT_LT((view[0].pixel - Eigen::Vector2d(157, 127)).norm(), 1e-10);
  EXPECT_LT((view[0].view_change - Eigen::Matrix2d::Identity()).norm(), 1e-10);
  EXPECT_NEAR(view[0].S(0, 0), std::pow(197 * 0.02, 2) + 0.01 + 1, 0.01 * view[0].S(0, 0));
  EXPECT_NEAR(view[0].S(1, 1), std::pow(195 * 0.02, 2) + 0.01 + 1, 0.01 * view[0].S(1, 1));
}

TEST(ActiveSearch, FindsALandmarkThatAWrongPosePredictsElsewhere) {
  const Scene scene({170, 120}, 0.025);  // 5 px away
  const Candidate candidate = scene.view().at(0);
  EXPECT_GT((candidate.pixel - Eigen::Vector2d(170, 120)).norm(), 4);
  const auto found = search_candidate(scene.image, scene.landmarks[0], candidate, {});
  ASSERT_TRUE(found);
  const Eigen::Vector2d at = candidate.pixel + Eigen::Vector2d(found->innovation);
  EXPECT_LT((at - Eigen::Vector2d(170, 120)).norm(), 0.1);  // px, displacement by the slight warp
}

TEST(ActiveSearch, FindsNothingBeyondThreeSigmaOrWhereTheLandmarkIsGone) {
  const Scene turned({170, 120}, 0.06, 0.003), scene({170, 120});  // 12 px away, 3σ of 1.1 px twice
  EXPECT_FALSE(search_candidate(turned.image, turned.landmarks[0], turned.view().at(0), {}));
  cv::Mat other;
  cv::flip(scene.image, other, -1);
  EXPECT_FALSE(search_candidate(other, scene.landmarks[0], scene.view().at(0), {}));
}

TEST(ActiveSearch, DoesNotPredictLandmarksBehindOutsideOrTooNearTheBorder) {
  EXPECT_TRUE(Scene({170, 120}, 3.1).view().empty());  // behind
  EXPECT_TRUE(Scene({170, 120}, 1.2).view().empty());  // outside
  EXPECT_EQ(Scene({20, 120}, 0).view().size(), 1u);
  EXPECT_TRUE(Scene({20, 120}, -0.12).view().empty());  // within 7 px of the border
}

/// Candidates with innovations of these standard deviations, px.
std::vector<Candidate> with_sigmas(const std::vector<double>& sigmas) {
  std::vector<Candidate> candidates(sigmas.size(), Scene({170, 120}).view()[0]);
  for (std::size_t i = 0; i < sigmas.size(); ++i) {
    candidates[i].index = i;
    candidates[i].S = sigmas[i] * sigmas[i] * Eigen::Matrix2d::Identity();
  }
  return candidates;
}

std::vector<std::size_t> indices(const std::vector<Candidate>& candidates) {
  std::vector<std::size_t> all;
  for (const Candidate& candidate : candidates) all.push_back(candidate.index);
  return all;
}

TEST(ActiveSearch, KeepsTheMostUncertainInnovationsInDescendingOrderWithinThePixelBound) {
  auto most = with_sigmas({1, 1.1, 1.2, 3, 1.15}), affordable = with_sigmas({1, 1, 3, 4});
  keep_most_informative(most, 3);
  EXPECT_EQ(indices(most), (std::vector<std::size_t>{3, 2, 4}));
  keep_affordable(affordable, 49 + 49 + 361 + 625);                        // boxes of 7, 7, 19 and 25 px
  EXPECT_EQ(indices(affordable), (std::vector<std::size_t>{0, 1, 2, 3}));  // unsorted if all are affordable
  keep_affordable(affordable, 49 + 625);
  EXPECT_EQ(indices(affordable), (std::vector<std::size_t>{3, 0}));  // the 19 px box no longer fits
}

TEST(LineSearch, SidewaysMotionFindsTheDepthOfAFarWallAndNeverANearOne) {
  // A wall at 5 m facing a pinhole of 200 px that moves sideways: the picture shifts by 40 px per meter.
  constexpr double kWall_m = 5, kFocal_px = 200;
  CameraIntrinsics intrinsics;
  intrinsics.lens = OneParameterRadial{};
  intrinsics.fu_px = intrinsics.fv_px = kFocal_px;
  const Camera camera(intrinsics);
  const cv::Mat wide = random_blocks(420, 6, 5);
  const RobotVector x = looking_ahead({0, 0, 0});
  Options options;
  options.depth.first_sight = FirstSight::particles;
  Landmark landmark;
  landmark.kind = SemiInfiniteLine{uniform_prior(options.depth.particles)};
  landmark.patch = cut_patch(wide(cv::Rect(0, 0, 320, 240)), {200, 120});
  landmark.at = kRobot;
  const LandmarkInitialization line = initialize_line(x, *camera.unproject({200, 120}), 1);
  for (const int shift_px : {4, 8, 12, 16, 20}) {
    RobotVector moved = x;
    moved(kPosition + 1) = -shift_px * kWall_m / kFocal_px;
    Kalman kalman({moved, 1e-6 * RobotMatrix::Identity()}, false);
    LandmarkInitialization still = line;
    still.J_robot.setZero();
    kalman.append(still);
    landmark.X_WC_first = kalman.state().X_WC();
    landmark.X_WC_first.translation().setZero();
    search_line(wide(cv::Rect(shift_px, 0, 320, 240)), kalman, camera, options.vision, landmark);
  }
  const auto& found = std::get<SemiInfiniteLine>(landmark.kind);
  ASSERT_FALSE(found.particles.empty());
  EXPECT_EQ(found.attempts, 5);
  const DepthMoments depth = depth_moments(found.particles);
  EXPECT_LT(std::abs(depth.mean_m - kWall_m), 2 * depth.sigma_m);
  EXPECT_LT(depth.sigma_m, 0.3 * depth.mean_m);
  EXPECT_GT(found.particles.front().depth_m, 2.5);
}

/// The strongest corner in a box of a picture of a wall at x = 3.6 m, viewed from other places.
struct Sight {
  explicit Sight(const cv::Rect& box) {
    const Eigen::Isometry3d X_WC = landmark.X_WC_first = camera_pose(looking_ahead({1, 1.2, 1.4}));
    const cv::Mat image = room.render(camera, X_WC, 2);
    const Eigen::Vector2i corner = strongest_corner(image, box, 1000)->pixel;
    landmark.kind = Point{};
    landmark.at = kRobot;
    landmark.patch = cut_patch(image, corner);
    p_W = room.hit(X_WC.translation(), X_WC.linear() * camera.unproject(corner.cast<double>())->h);
    EXPECT_NEAR(p_W.x(), 3.6, 1e-3);
  }
  /// Looks eight times from each of the places to the right.
  void look(std::initializer_list<double> places_m) {
    for (const double aside : places_m) {
      Kalman kalman({looking_ahead({1, 1.2 - aside, 1.4}), RobotMatrix::Identity()}, false);
      kalman.append_point(p_W, 0.01);
      const Eigen::Isometry3d X_WC = kalman.state().X_WC();
      const cv::Mat image = room.render(camera, X_WC, 2);
      const Eigen::Vector2d pixel = camera.project(X_WC.inverse() * p_W)->pixel;
      for (int i = 0; i < 8; ++i)
        landmark.tilt = refined_tilt(image, landmark, pixel, camera, kalman.state());
    }
  }
  double degrees_from_wall() const {
    return std::acos(-surface_normal(landmark.X_WC_first, p_W, landmark.tilt).x()) * 180 / std::numbers::pi;
  }

  synthetic::Room room;
  Camera camera{CameraIntrinsics{}};
  Landmark landmark;
  Eigen::Vector3d p_W;
};

TEST(Surface, TheNormalOfAWallIsEstimatedFromLaterViews) {
  Sight facing(cv::Rect(140, 100, 40, 40)), askew(cv::Rect(215, 40, 85, 70));
  const double before = askew.degrees_from_wall();
  ASSERT_GT(before, 25);
  askew.look({0});
  EXPECT_EQ(askew.landmark.tilt, Eigen::Vector2d(0, 0));
  for (Sight* sight : {&facing, &askew}) sight->look({0.4, 0.8, 1.2});
  EXPECT_LT(facing.degrees_from_wall(), 10);
  EXPECT_LT(askew.degrees_from_wall(), before / 3);  // not 0: the prior prefers small tilts
}

TEST(Corners, TheStrongestMatchesOpenCvsEigenvalues) {
  const cv::Mat image = pattern(0, 0);
  const cv::Rect region(30, 25, 80, 60);
  const auto corner = strongest_corner(image, region, 1000);
  ASSERT_TRUE(corner);
  const cv::Matx13d slope(-0.5, 0, 0.5);
  cv::Mat gx, gy, root;
  cv::filter2D(image, gx, CV_64F, slope);
  cv::filter2D(image, gy, CV_64F, slope.t());
  const auto summed = [](const cv::Mat& product) {
    cv::Mat sums;
    cv::boxFilter(product, sums, CV_64F, {11, 11}, {-1, -1}, false);
    return sums;
  };
  const cv::Mat xx = summed(gx.mul(gx)), xy = summed(gx.mul(gy)), yy = summed(gy.mul(gy)), d = xx - yy;
  cv::sqrt(d.mul(d) + 4 * xy.mul(xy), root);
  const cv::Mat smaller = (xx + yy - root) / 2;  // eigenvalue
  double best = 0;
  cv::Point where;
  cv::minMaxLoc(smaller(region), nullptr, &best, nullptr, &where);
  EXPECT_EQ(corner->pixel, Eigen::Vector2i(region.x + where.x, region.y + where.y));
  EXPECT_NEAR(corner->strength, best, 1e-9 * best);
}

TEST(Corners, AreProposedAwayFromOccupiedPixels) {
  const cv::Mat image = random_blocks(320, 8, 5);
  std::mt19937_64 random(1);
  std::vector<Eigen::Vector2d> occupied;
  for (int k = 0; k < 60; ++k)
    if (const auto corner = propose_corner(image, occupied, Options::Vision{}, random))
      occupied.push_back(corner->cast<double>());
  EXPECT_GE(occupied.size(), 8u);
  for (std::size_t i = 0; i < occupied.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE((occupied[i] - occupied[j]).norm(), 20);
}

TEST(Corners, AreProposedInDarkImagesButNotInNoise) {
  const auto proposed = [](const cv::Mat& image) {
    std::mt19937_64 random(1);
    int count = 0;
    for (int k = 0; k < 60; ++k)
      if (propose_corner(image, {}, Options::Vision{}, random)) ++count;
    return count;
  };
  const cv::Mat dark = 0.1 * random_blocks(320, 8, 5);
  EXPECT_FALSE(strongest_corner(dark, {0, 0, 320, 240}, Options::Vision::corner_threshold));
  EXPECT_GT(proposed(dark), 50);
  cv::Mat black(240, 320, CV_8UC1, cv::Scalar(10)), noise(240, 320, CV_8SC1);
  cv::theRNG().state = 1;
  cv::randn(noise, 0, 2);
  cv::add(black, noise, black, {}, CV_8U);
  EXPECT_EQ(proposed(black), 0);
}

TEST(Corners, AreFoundNearAPixelWithinThreeSigma) {
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(60));
  image(cv::Rect(160, 120, 160, 120)).setTo(cv::Scalar(200));  // its corner is at (159.5, 119.5)
  const Eigen::Vector2d near(161, 121);
  const auto corner = corner_near(image, near, Eigen::Matrix2d::Identity());
  ASSERT_TRUE(corner);
  EXPECT_LT((*corner - Eigen::Vector2d(159.5, 119.5)).norm(), 0.1);  // interpolation between pixels
  EXPECT_FALSE(corner_near(image, near, 0.01 * Eigen::Matrix2d::Identity()));
}

}  // namespace
}  // namespace slam
