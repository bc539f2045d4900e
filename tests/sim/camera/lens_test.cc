#include "sim/camera/lens.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/camera/shutter.h"
#include "sim/physics/model.h"

namespace sim::camera {
namespace {

std::vector<CameraOptions> all_cameras() {
  std::vector<CameraOptions> cameras;
  for (Lens lens : {Lens::wide, Lens::pinhole})
    for (int width : {320, 640}) {
      CameraOptions options;
      options.width_px = width, options.height_px = width * 3 / 4, options.lens = lens;
      cameras.push_back(options);
    }
  return cameras;
}

double degrees_across(const CameraModel& camera) {
  const double left = camera.direction({-0.5, camera.v0_px}).x();
  const double right = camera.direction({camera.width_px - 0.5, camera.v0_px}).x();
  return (std::atan(right) - std::atan(left)) * 180 / std::numbers::pi;
}

// The view of a column.
const Pinhole& view_of(const LensWarp& lens, const CameraOptions& options, int u) {
  return lens.views()[std::size_t(u) * lens.views().size() / std::size_t(options.width_px)];
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
      const Eigen::Vector2d direction = camera.direction(uv);
      const Eigen::Vector2d back = camera.project(3.7 * direction.homogeneous());
      EXPECT_LT((back - uv).norm(), 1e-10);  // px: rounding of a few operations on numbers of some hundreds
    }
  }
}

TEST(CameraModel, TheDistortionIsRelativeToThatOfThePapersCamera) {
  CameraOptions options;
  options.distortion = 0.7;
  EXPECT_DOUBLE_EQ(camera_model(options).k1_px2, 0.7 * 7.37e-6);
  options.distortion = 1.3;  // the most: every pixel still has a direction
  EXPECT_TRUE(camera_model(options).direction({319, 0}).allFinite());
}

TEST(CameraModel, WideCameraSees91Point6DegreesAndThePinhole90AtBothSizes) {
  for (const CameraOptions& options : all_cameras()) {
    const double expected = options.lens == Lens::wide ? 91.6 : 90.0;
    EXPECT_NEAR(degrees_across(camera_model(options)), expected, 0.1);  // 91.6 is given to one digit
  }
}

TEST(LensWarp, NoPixelSamplesOutsideItsView) {
  constexpr double kKernel = 2;  // px a bicubic sample reaches
  for (const CameraOptions& options : all_cameras())
    for (double density : {1.0, 1.4}) {
      const LensWarp lens(camera_model(options), density);
      for (int v = 0; v < options.height_px; ++v)
        for (int u = 0; u < options.width_px; ++u) {
          const Pinhole& view = view_of(lens, options, u);
          const Eigen::Vector2d pixel = lens.source_pixel(u, v) - Eigen::Vector2d(view.first_column, 0);
          ASSERT_GE(pixel.minCoeff(), kKernel - 1);
          ASSERT_LE(pixel.x(), view.width_px - kKernel);
          ASSERT_LE(pixel.y(), view.height_px - kKernel);
        }
    }
}

// In a view's own columns; where two views meet, the step leads from one to the other.
TEST(LensWarp, NeighboringPixelsAreAtLeastAsFarApartInTheSourceAsTheDensitySays) {
  for (const CameraOptions& options : all_cameras()) {
    const LensWarp lens(camera_model(options), 1.2);
    for (int v = 0; v + 1 < options.height_px; v += 3)
      for (int u = 0; u + 1 < options.width_px; u += 3) {
        if (&view_of(lens, options, u) != &view_of(lens, options, u + 1)) continue;
        const Eigen::Vector2d pixel = lens.source_pixel(u, v);
        ASSERT_GE((lens.source_pixel(u + 1, v) - pixel).norm(), 1.2 * 0.999) << u << " " << v;
        ASSERT_GE((lens.source_pixel(u, v + 1) - pixel).norm(), 1.2 * 0.999) << u << " " << v;
      }
  }
}

// One pinhole that covers the wide lens at this density has 597 x 447 px; the ideal pinhole is its own best
// view.
TEST(LensWarp, AWideLensIsDrawnInTwoViewsOfTwoThirdsOfThePixelsAndAPinholeInOne) {
  CameraOptions options;
  const LensWarp wide(camera_model(options), 1.15);
  ASSERT_EQ(wide.views().size(), 2u);
  EXPECT_LT(wide.views()[0].width_px * wide.views()[0].height_px +
                wide.views()[1].width_px * wide.views()[1].height_px,
            0.67 * 597 * 447);
  options.lens = Lens::pinhole;
  EXPECT_EQ(LensWarp(camera_model(options), 1.15).views().size(), 1u);
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
    const LensWarp lens(camera, 1.0);
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

using namespace physics;
namespace {

CameraOptions camera(double exposure_s, double readout_s, int subframes) {
  CameraOptions options;
  options.exposure_s = exposure_s, options.readout_s = readout_s, options.subframes = subframes;
  return options;
}

// The moment a row sees on average, by the shares of the pictures it is made of.
double mean_moment(const Shutter& shutter, int row) {
  double sum = 0;
  for (int i = 0; i < int(shutter.moments().size()); ++i)
    sum += shutter.moments()[std::size_t(i)] * double(shutter.shares()(i, row));
  return sum;
}

}  // namespace

TEST(Shutter, ThatTakesNoTimeIsOnePictureAtTheStamp) {
  const Shutter shutter(camera(0, 0, 8));
  EXPECT_EQ(shutter.moments(), std::vector<double>{0});
  EXPECT_EQ(shutter.lead().count(), 0);
  const cv::Mat1b picture(240, 320, uchar(77));
  EXPECT_EQ(shutter.expose({picture}).data, picture.data);
}

TEST(Shutter, EachRowGathersAllItsLightAroundItsOwnMoment) {
  for (auto [exposure, readout] : {std::pair(0.008, 0.0), std::pair(0.0, 0.02), std::pair(0.01, 0.016)}) {
    const Shutter shutter(camera(exposure, readout, 9));
    for (int row = 0; row < 240; ++row) {
      float sum = 0;
      for (int i = 0; i < 9; ++i) sum += shutter.shares()(i, row);
      ASSERT_NEAR(sum, 1, 1e-5);
      ASSERT_NEAR(mean_moment(shutter, row), readout * ((row + 0.5) / 240 - 0.5),
                  1e-8);  // rounding of floats
    }
  }
}

TEST(Shutter, HasClosedWhenItsLeadIsOver) {
  EXPECT_EQ(Shutter(camera(0.01, 0.016, 9)).lead().count(), 13);
  EXPECT_EQ(Shutter(camera(0.005, 0, 9)).lead().count(), 3);
}

// A light that grows evenly from 0 to 200 during the exposure leaves 100; a row that is read a quarter of the
// span earlier sees 50 less.
TEST(Shutter, RowsOfAGrowingLightAreAsBrightAsTheirMomentsSay) {
  const Shutter blur(camera(0.01, 0, 9)), rolling(camera(0, 0.01, 9));
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 9; ++i) pictures.push_back(cv::Mat1b(240, 4, uchar(25 * i)));
  const cv::Mat1b blurred = blur.expose(pictures), rolled = rolling.expose(pictures);
  for (int row = 0; row < 240; ++row) {
    ASSERT_EQ(blurred(row, 2), 100);
    ASSERT_NEAR(rolled(row, 2), 200 * (row + 0.5) / 240, 0.51);  // rounded to whole levels
  }
}

TEST(RecentMotion, IsInterpolatedEvenlyAndTurnsTheShortWay) {
  const std::filesystem::path models = std::filesystem::path(GAITSLAM_SOURCE_DIR) / "models";
  const Model model = load_model("hrp2", "floor", models);
  const Data data(mj_makeData(model.get()));
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
