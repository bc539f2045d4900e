#include "sim/world/lens.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace sim::world {
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

}  // namespace

// Computed by hand to ten digits from the formula of Davison et al. 2007 with f = 195, centre (162, 125), K1
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

TEST(CameraModel, WideCameraSees91Point6DegreesAndThePinhole90AtBothSizes) {
  for (const CameraOptions& options : all_cameras()) {
    const double expected = options.lens == Lens::wide ? 91.6 : 90.0;
    EXPECT_NEAR(degrees_across(camera_model(options)), expected, 0.1);  // 91.6 is given to one digit
  }
}

TEST(LensWarp, NoPixelSamplesOutsideTheSource) {
  constexpr double kKernel = 2;  // px a bicubic sample reaches
  for (const CameraOptions& options : all_cameras())
    for (double density : {1.0, 1.4}) {
      const LensWarp lens(camera_model(options), density);
      for (int v = 0; v < options.height_px; ++v)
        for (int u = 0; u < options.width_px; ++u) {
          const Eigen::Vector2d pixel = lens.source_pixel(u, v);
          ASSERT_GE(pixel.minCoeff(), kKernel - 1);
          ASSERT_LE(pixel.x(), lens.source().width_px - kKernel);
          ASSERT_LE(pixel.y(), lens.source().height_px - kKernel);
        }
    }
}

// A smooth pattern over directions, painted into the source by its definition, must appear in the image where
// the lens formula puts it: half pixels, the flip of OpenGL's rows and the scale all show in this.
TEST(LensWarp, ImageShowsAtEachPixelWhatItsDirectionSees) {
  const auto pattern = [](double x, double y) {
    return 127.5 + 100 * std::sin(9 * x + 1) * std::cos(7 * y - 0.5);
  };
  for (const CameraOptions& options : all_cameras()) {
    const CameraModel camera = camera_model(options);
    const LensWarp lens(camera, 1.0);
    const Pinhole source = lens.source();
    cv::Mat1b bottom_up(source.height_px, source.width_px);
    for (int row = 0; row < source.height_px; ++row)
      for (int column = 0; column < source.width_px; ++column)
        bottom_up(source.height_px - 1 - row, column) = cv::saturate_cast<uchar>(pattern(
            source.left + (column + 0.5) / source.focal_px, source.top + (row + 0.5) / source.focal_px));
    const cv::Mat1b image = lens.warp(bottom_up);
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

}  // namespace sim::world
