#include "slam/vision/active_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "slam/vision/corner_detector.h"
#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

/// Smoothed noise: no two places alike.
cv::Mat picture() {
  cv::Mat smooth;
  cv::GaussianBlur(random_blocks(320, 1, 3), smooth, cv::Size(0, 0), 2);
  cv::normalize(smooth, smooth, 0, 255, cv::NORM_MINMAX);
  return smooth;
}

/// A camera that looks along +x, its landmark 4 m away at `pixel`, and the estimated rotation of the camera
/// about the vertical at the search.
struct Scene {
  explicit Scene(const Eigen::Vector2i& pixel, double turned = 0, double sigma_turn = 0.01) {
    RobotVector x = looking_ahead({0, 0, 0});
    const Eigen::Vector4d q_first = x.segment<4>(kOrientation);
    Landmark landmark;
    landmark.X_WC_first.linear() = rotation_matrix(q_first);
    landmark.patch = cut_patch(image, pixel);
    landmark.kind = InverseDepth{};
    x.segment<4>(kOrientation) = quaternion_product(quaternion_exp({0, 0, turned}), q_first);
    RobotMatrix P = RobotMatrix::Zero();
    const Matrix43d dq = small_rotation_jacobian(x.segment<4>(kOrientation));
    P.block<4, 4>(kOrientation, kOrientation) = sigma_turn * sigma_turn * dq * dq.transpose();
    kalman = std::make_unique<Kalman>(RobotState{x, P}, false);
    const auto ray = camera.unproject(pixel.cast<double>());
    RobotVector x_first = x;
    x_first.segment<4>(kOrientation) = q_first;
    Options::Depth depth;
    depth.inverse_1_m = 0.25;
    LandmarkInitialization initial =
        initialize_inverse_depth(x_first, *ray, 0.1, Eigen::Vector2d::Zero(), depth);
    initial.J_robot.setZero();  // independent of the present pose
    landmark.at = kalman->append(initial);
    landmarks = {landmark};
  }
  std::vector<Candidate> view() const { return predict_view(*kalman, landmarks, camera, 1); }

  cv::Mat image = picture();
  Camera camera{CameraIntrinsics{}};
  std::unique_ptr<Kalman> kalman;
  std::vector<Landmark> landmarks;
};

TEST(ActiveSearch, PredictsALandmarkWhereItWasFirstSeenFromThere) {
  const Scene scene({200, 90});
  const auto view = scene.view();
  ASSERT_EQ(view.size(), 1u);
  EXPECT_LT((view[0].pixel - Eigen::Vector2d(200, 90)).norm(), 1e-10);
  EXPECT_LT((view[0].view_change - Eigen::Matrix2d::Identity()).norm(), 1e-10);
}

TEST(ActiveSearch, InnovationCovarianceIsThatOfPoseLandmarkAndPixel) {
  const double sigma_turn = 0.02;
  const Scene scene({157, 127}, 0, sigma_turn);  // at the center, where a turn of θ moves the image by f θ
  const auto view = scene.view();
  ASSERT_EQ(view.size(), 1u);
  EXPECT_NEAR(view[0].S(0, 0), std::pow(197 * sigma_turn, 2) + 0.01 + 1, 0.01 * view[0].S(0, 0));
  EXPECT_NEAR(view[0].S(1, 1), std::pow(195 * sigma_turn, 2) + 0.01 + 1, 0.01 * view[0].S(1, 1));
}

TEST(ActiveSearch, FindsALandmarkThatAWrongPosePredictsElsewhere) {
  const Scene scene({170, 120}, 0.025);  // 5 px away
  const auto view = scene.view();
  ASSERT_EQ(view.size(), 1u);
  EXPECT_GT((view[0].pixel - Eigen::Vector2d(170, 120)).norm(), 4);
  const auto found = search_candidate(scene.image, scene.landmarks[0], view[0], Options::Vision{});
  ASSERT_TRUE(found);
  const Eigen::Vector2d at = view[0].pixel + Eigen::Vector2d(found->innovation);
  EXPECT_LT((at - Eigen::Vector2d(170, 120)).norm(), 0.1);  // px, what the slight warp displaces
}

TEST(ActiveSearch, DoesNotSearchBeyondThreeSigma) {
  const Scene scene({170, 120}, 0.06, 0.003);  // 12 px away, 3σ of 1.1 px twice
  const auto view = scene.view();
  ASSERT_EQ(view.size(), 1u);
  EXPECT_FALSE(search_candidate(scene.image, scene.landmarks[0], view[0], Options::Vision{}));
}

TEST(ActiveSearch, FindsNothingWhereTheLandmarkHasGone) {
  const Scene scene({170, 120});
  cv::Mat other;
  cv::flip(scene.image, other, -1);
  EXPECT_FALSE(search_candidate(other, scene.landmarks[0], scene.view()[0], Options::Vision{}));
}

TEST(ActiveSearch, PredictsNothingThatIsBehindOrOutsideOrTooNearTheBorder) {
  EXPECT_TRUE(Scene({170, 120}, 3.1).view().empty());  // behind
  EXPECT_TRUE(Scene({170, 120}, 1.2).view().empty());  // outside
  EXPECT_EQ(Scene({20, 120}, 0).view().size(), 1u);
  EXPECT_TRUE(Scene({20, 120}, -0.12).view().empty());  // within 7 px of the border
}

TEST(ActiveSearch, KeepsTheMostUncertainInnovationsInFallingOrder) {
  const Scene scene({170, 120});
  std::vector<Candidate> candidates(5, scene.view()[0]);
  for (std::size_t i = 0; i < 5; ++i) {
    candidates[i].index = i;
    candidates[i].S = Eigen::Vector2d(i == 3 ? 9 : 1 + 0.1 * static_cast<double>(i), 1).asDiagonal();
  }
  keep_most_informative(candidates, 3);
  ASSERT_EQ(candidates.size(), 3u);
  EXPECT_EQ(candidates[0].index, 3u);
  EXPECT_EQ(candidates[1].index, 4u);
  EXPECT_EQ(candidates[2].index, 2u);
}

TEST(ActiveSearch, KeepsTheMostUncertainCandidatesThatTheBoundOnPixelsAllows) {
  const Scene scene({170, 120});
  std::vector<Candidate> candidates(4, scene.view()[0]);
  for (std::size_t i = 0; i < 4; ++i) {
    candidates[i].index = i;
    const double sigma = i == 1 ? 1 : 1 + static_cast<double>(i);  // boxes of 7, 7, 19 and 25 px
    candidates[i].S = sigma * sigma * Eigen::Matrix2d::Identity();
  }
  const auto all = candidates;
  keep_affordable(candidates, 49 + 49 + 361 + 625);
  EXPECT_EQ(candidates.size(), 4u);
  EXPECT_EQ(candidates[3].index, 3u);  // nothing is sorted as long as all are affordable
  keep_affordable(candidates, 49 + 625);
  ASSERT_EQ(candidates.size(), 2u);
  EXPECT_EQ(candidates[0].index, 3u);
  EXPECT_EQ(candidates[1].index, 0u);  // the one of 19 px does not fit any more
}

TEST(LineSearch, SidewaysMotionFindsTheDepthOfAFarWallAndNeverANearOne) {
  // A wall at 5 m facing a pinhole of 200 px that moves sideways: the picture shifts by 40 px a metre.
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
  EXPECT_TRUE(converged(found, options.depth.particles));
  EXPECT_GT(found.particles.front().depth_m, 2.5);
}

/// A camera 1.4 m above the floor, turned by `heading` to the left of +x.
Eigen::Isometry3d level(double x, double y, double heading) {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.translation() = Eigen::Vector3d(x, y, 1.4);
  X_WC.linear().col(2) = Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
  X_WC.linear().col(1) = -Eigen::Vector3d::UnitZ();
  X_WC.linear().col(0) = X_WC.linear().col(1).cross(X_WC.linear().col(2));
  return X_WC;
}

State state(const Eigen::Isometry3d& X_WC, const Eigen::Vector3d& p_W) {
  State s;
  s.size = kRobot + Point::kSize;
  s.storage_x = Eigen::VectorXd::Zero(s.size);
  s.storage_x.segment<3>(kPosition) = X_WC.translation();
  const Eigen::Quaterniond q(X_WC.linear());
  s.storage_x.segment<4>(kOrientation) << q.w(), q.x(), q.y(), q.z();
  s.storage_x.tail<3>() = p_W;
  return s;
}

/// The strongest corner of a box of the first picture, its place known, and looks at it from elsewhere.
struct Sight {
  Sight(const Eigen::Isometry3d& X_WC_first, const cv::Rect& box) {
    const cv::Mat image = room.render(camera, X_WC_first, 2);
    const auto corner = strongest_corner(image, box, 1000).value();
    landmark.kind = Point{};
    landmark.at = kRobot;
    landmark.patch = cut_patch(image, corner.pixel);
    landmark.X_WC_first = X_WC_first;
    const Eigen::Vector3d ray = X_WC_first.linear() * camera.unproject(corner.pixel.cast<double>())->h;
    p_W = room.hit(X_WC_first.translation(), ray);
  }
  void look(const Eigen::Isometry3d& X_WC, int times) {
    const cv::Mat image = room.render(camera, X_WC, 2);
    const Eigen::Vector2d pixel = camera.project(X_WC.inverse() * p_W)->pixel;
    for (int i = 0; i < times; ++i)
      landmark.tilt = refined_tilt(image, landmark, pixel, camera, state(X_WC, p_W));
  }
  Eigen::Vector3d normal() const { return surface_normal(landmark.X_WC_first, p_W, landmark.tilt); }

  synthetic::Room room;
  Camera camera{CameraIntrinsics{}};
  Landmark landmark;
  Eigen::Vector3d p_W;
};

double degrees_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(a.dot(b)) * 180 / std::numbers::pi;
}

TEST(Surface, TheNormalOfAWallFirstSeenObliquelyIsEstimatedFromOtherViews) {
  Sight sight(level(1.0, 1.2, 0.0), cv::Rect(215, 40, 85, 70));
  ASSERT_NEAR(sight.p_W.x(), 3.6, 1e-3);  // on the wall ahead, to the right
  const Eigen::Vector3d wall(-1, 0, 0);
  const double before = degrees_between(sight.normal(), wall);
  ASSERT_GT(before, 25);
  for (const double aside : {0.4, 0.8, 1.2}) sight.look(level(1.0, 1.2 - aside, 0.0), 8);
  EXPECT_LT(degrees_between(sight.normal(), wall), before / 3);  // not 0: the prior prefers small tilts
}

TEST(Surface, ARightNormalAndOneWhoseViewHasNotChangedStay) {
  Sight facing(level(1.0, 1.2, 0.0), cv::Rect(140, 100, 40, 40));
  ASSERT_NEAR(facing.p_W.x(), 3.6, 1e-3);
  for (const double aside : {0.4, 0.8, 1.2}) facing.look(level(1.0, 1.2 - aside, 0.0), 8);
  EXPECT_LT(degrees_between(facing.normal(), {-1, 0, 0}), 10);
  Sight askew(level(1.0, 1.2, 0.0), cv::Rect(215, 40, 85, 70));
  askew.look(level(1.0, 1.2, 0.0), 8);
  EXPECT_EQ(askew.landmark.tilt, Eigen::Vector2d(0, 0));
}

}  // namespace
}  // namespace slam
