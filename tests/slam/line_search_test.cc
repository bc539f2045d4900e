#include "slam/vision/active_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

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

}  // namespace
}  // namespace slam
