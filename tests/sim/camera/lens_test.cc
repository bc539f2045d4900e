#include "sim/camera/lens.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/camera/head_camera.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::camera {
namespace {

// With the paper's lens, with the strongest, and without distortion.
std::vector<CameraOptions> all_cameras() {
  std::vector<CameraOptions> cameras;
  for (double distortion : {1.0, 1.3, 0.0})
    for (int width : {320, 640}) {
      CameraOptions& options = cameras.emplace_back();
      options.width_px = width, options.height_px = width * 3 / 4, options.distortion = distortion;
    }
  return cameras;
}

// The view of a column.
const Pinhole& view_of(const LensWarp& lens, const CameraOptions& options, int u) {
  return lens.views()[u < options.width_px / 2 ? 0 : 1];
}

}  // namespace

// Computed by hand to ten digits from the formula of Davison et al. 2007 with f = 195, center (162, 125), K1
// = 9e-6.
TEST(CameraModel, ProjectsAsMonoSlamsCameraDoes) {
  const CameraModel camera{320, 240, 195, 195, 162, 125, 9e-6};
  const Eigen::Vector2d uv = camera.project({0.4, -0.3, 2.0});
  EXPECT_NEAR(uv.x(), 200.1916701636, 1e-9);
  EXPECT_NEAR(uv.y(), 96.3562473773, 1e-9);
}

TEST(CameraModel, APixelsDirectionProjectsToThatPixel) {
  for (const CameraOptions& options : all_cameras()) {
    const CameraModel camera = camera_model(options);
    for (const Eigen::Vector2d& uv :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(317.3, 2.25), Eigen::Vector2d(41, 238.5)}) {
      const Eigen::Vector2d back = camera.project(3.7 * camera.direction(uv).homogeneous());
      EXPECT_LT((back - uv).norm(), 1e-10);  // px: rounding of a few operations on numbers of some hundreds
    }
  }
}

TEST(CameraModel, SeesAcross91Point6DegreesAtBothSizes) {
  for (const CameraOptions& options : all_cameras()) {
    if (options.distortion != 1) continue;
    const CameraModel camera = camera_model(options);
    const auto angle = [&](double u) { return std::atan(camera.direction({u, camera.v0_px}).x()); };
    const double across = (angle(camera.width_px - 0.5) - angle(-0.5)) * 180 / std::numbers::pi;
    EXPECT_NEAR(across, 91.6, 0.1);  // given to one digit
  }
}

// In a view's own columns; where two views meet, the step leads from one to the other.
TEST(LensWarp, PixelsSampleInsideTheirViewAtLeastAsFarApartAsTheDensitySays) {
  constexpr double kKernel = 2;  // px a bicubic sample reaches
  for (const CameraOptions& options : all_cameras()) {
    const LensWarp lens(camera_model(options));
    for (int v = 0; v < options.height_px; ++v)
      for (int u = 0; u < options.width_px; ++u) {
        const Pinhole& view = view_of(lens, options, u);
        const Eigen::Vector2d source = lens.source_pixel(u, v),
                              pixel = source - Eigen::Vector2d(view.first_column, 0);
        ASSERT_GE(pixel.minCoeff(), kKernel - 1);
        ASSERT_LE(pixel.x(), view.width_px - kKernel);
        ASSERT_LE(pixel.y(), view.height_px - kKernel);
        if (u + 1 == options.width_px || &view != &view_of(lens, options, u + 1)) continue;
        ASSERT_GE((lens.source_pixel(u + 1, v) - source).norm(), kSourceDensity * 0.999) << u << " " << v;
        ASSERT_GE((lens.source_pixel(u, v + 1) - source).norm(), kSourceDensity * 0.999) << u << " " << v;
      }
  }
}

// One pinhole that covers the lens at this density has 623 x 466 px.
TEST(LensWarp, TheTwoViewsHaveTwoThirdsOfThePixelsOfOne) {
  const LensWarp lens(camera_model({}));
  double pixels = 0;
  for (const Pinhole& view : lens.views()) pixels += view.width_px * view.height_px;
  EXPECT_LT(pixels, 0.67 * 623 * 466);
}

// A smooth pattern over directions, painted into the views by their definition, must appear in the image
// at its projection by the lens formula: half pixels, the views' turns, their seam and the scale all show in
// this.
TEST(LensWarp, ImageShowsAtEachPixelWhatItsDirectionSees) {
  const auto pattern = [](double x, double y) {
    return 127.5 + 100 * std::sin(9 * x + 1) * std::cos(7 * y - 0.5);
  };
  for (const CameraOptions& options : all_cameras()) {
    const CameraModel camera = camera_model(options);
    const LensWarp lens(camera);
    int height = 0, width = 0;
    for (const Pinhole& view : lens.views())
      height = std::max(height, view.height_px), width = view.first_column + view.width_px;
    cv::Mat1b views(height, width, uchar(0));
    for (const Pinhole& view : lens.views())
      for (int row = 0; row < view.height_px; ++row)
        for (int column = 0; column < view.width_px; ++column) {
          const Eigen::Vector3d ray = Eigen::AngleAxisd(view.yaw, Eigen::Vector3d::UnitY()) *
                                      Eigen::Vector3d(view.left + (column + 0.5) / view.focal_px,
                                                      view.top + (row + 0.5) / view.focal_px, 1);
          views(row, view.first_column + column) =
              cv::saturate_cast<uchar>(pattern(ray.x() / ray.z(), ray.y() / ray.z()));
        }
    const cv::Mat1b image = lens.warp(views);
    ASSERT_EQ(image.size(), cv::Size(options.width_px, options.height_px));
    for (int v = 0; v < image.rows; v += 7)
      for (int u = 0; u < image.cols; u += 5) {
        const Eigen::Vector2d direction = camera.direction({u, v});
        // Rounding twice to grey levels, 1/64 px of the warp's fixed point at a slope of at most 5 levels a
        // pixel.
        ASSERT_NEAR(image(v, u), pattern(direction.x(), direction.y()), 1.6) << u << " " << v;
      }
  }
}

namespace {

CameraOptions camera(double exposure_s, double readout_s, int subframes) {
  CameraOptions options;
  options.exposure_s = exposure_s, options.readout_s = readout_s, options.subframes = subframes;
  return options;
}

}  // namespace

TEST(Shutter, ThatTakesNoTimeIsOnePictureAtTheStamp) {
  const Shutter shutter(camera(0, 0, 8));
  EXPECT_EQ(shutter.moments(), std::vector<double>{0});
  EXPECT_EQ(shutter.lead().count(), 0);
  const cv::Mat1b picture(240, 320, uchar(77));
  EXPECT_EQ(shutter.expose({picture}).data, picture.data);
  EXPECT_EQ(Shutter(camera(0.01, 0.016, 9)).lead().count(), 13);  // of others: when they have closed
  EXPECT_EQ(Shutter(camera(0.005, 0, 9)).lead().count(), 3);
}

// Pictures that brighten evenly from 0 to 200: a row is as bright as the light at its own moment.
TEST(Shutter, RowsOfAGrowingLightAreAsBrightAsTheirMomentsSay) {
  for (auto [exposure, readout] : {std::pair(0.01, 0.0), std::pair(0.0, 0.01), std::pair(0.01, 0.03)}) {
    std::vector<cv::Mat> growing, even;
    for (int i = 0; i < 9; ++i) {
      growing.push_back(cv::Mat1b(240, 4, uchar(25 * i)));
      even.push_back(cv::Mat1b(240, 4, uchar(200)));
    }
    const Shutter shutter(camera(exposure, readout, 9));
    const cv::Mat1b rows = shutter.expose(growing), whole = shutter.expose(even);
    for (int row = 0; row < 240; ++row) {
      const double moment = readout * ((row + 0.5) / 240 - 0.5) / (exposure + readout);
      ASSERT_NEAR(rows(row, 2), 100 + 200 * moment, 0.51) << row;  // rounded to whole levels
      ASSERT_EQ(whole(row, 2), 200) << row;
    }
  }
}

TEST(RecentMotion, IsInterpolatedEvenlyAndTurnsTheShortWay) {
  const physics::Model model = physics::load_model("hrp2", "floor", physics::models());
  const physics::Data data = data_at_rest(*model);
  RecentMotion motion(std::chrono::milliseconds(3));
  for (int ms = 0; ms < 10; ++ms) {
    const double yaw = 0.02 * ms;
    data->qpos[0] = 0.5 * ms;
    data->qpos[3] = std::cos(yaw / 2), data->qpos[6] = std::sin(yaw / 2);
    motion.add(std::chrono::milliseconds(ms), *model, *data);
  }
  const Eigen::VectorXd q = motion.at(0.00725, *model);
  EXPECT_NEAR(q[0], 3.625, 1e-12);
  EXPECT_NEAR(2 * std::atan2(q[6], q[3]), 0.145, 1e-12);
  EXPECT_NEAR(motion.at(0.009, *model)[0], 4.5, 1e-12);
  EXPECT_NEAR(motion.at(0.1, *model)[0], 4.5, 1e-12);  // nothing later is known
  EXPECT_NEAR(motion.at(0.0, *model)[0], 2.5, 0.51);   // what is older than it keeps is gone
}

}  // namespace sim::camera
