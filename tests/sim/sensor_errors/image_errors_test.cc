#include "sim/sensor_errors/image_errors.h"

#include <gtest/gtest.h>

namespace sim::sensor_errors {
namespace {

using slam::Stamp;

cv::Mat even(int grey) { return cv::Mat(240, 320, CV_8UC1, cv::Scalar(grey)); }

ImageOptions silent() {
  ImageOptions sizes;
  sizes.read_sigma_grey = sizes.shot_sigma_grey = 0;
  return sizes;
}

struct Spread {
  double mean = 0, sigma = 0;
};

Spread spread(const ImageOptions& sizes, int grey) {
  cv::Scalar mean, sigma;
  cv::meanStdDev(ImageErrors(sizes, 1, {}).apply(even(grey), Stamp(1)), mean, sigma);
  return {mean[0], sigma[0]};
}

TEST(ImageErrors, GainMakesLightAndNoiseGreater) {
  ImageOptions sizes;
  sizes.read_sigma_grey = 2, sizes.shot_sigma_grey = 3, sizes.gain = 4;
  const Spread bright = spread(sizes, 40);
  const double expected = std::sqrt(16 * (4 + 9.0 * 40 / 255) + 1.0 / 12);  // 1/12: rounding to whole levels
  EXPECT_NEAR(bright.mean, 160, 0.018 * expected);  // five standard errors of 76800 pixels
  EXPECT_NEAR(bright.sigma / expected, 1, 0.013);
  EXPECT_NEAR(spread(sizes, 255).mean, 255, 1e-9);  // and saturates
}

TEST(ImageErrors, VignettingTakesItsFractionInTheCornersAndNothingInTheMiddle) {
  ImageOptions sizes = silent();
  sizes.vignetting_fraction = 0.5;
  const cv::Mat image = ImageErrors(sizes, 1, {}).apply(even(200), Stamp(1));
  EXPECT_EQ(image.at<unsigned char>(120, 160), 200);
  EXPECT_EQ(image.at<unsigned char>(0, 0), 100);
  EXPECT_EQ(image.at<unsigned char>(239, 319), 100);
  // Half-way to a corner a quarter of it is lost: 200 (1 - 0.5 / 4).
  EXPECT_NEAR(image.at<unsigned char>(60, 80), 175, 1);
}

TEST(ImageErrors, VignettingDarkensTheLightAndNotTheNoiseOfReadingIt) {
  ImageOptions sizes = silent();
  sizes.read_sigma_grey = 5;
  const auto corner = [&] {
    return ImageErrors(sizes, 1, {}).apply(even(100), Stamp(1))(cv::Rect(0, 0, 1, 1)).at<unsigned char>(0, 0);
  };
  const int plain = corner();
  sizes.vignetting_fraction = 0.5;
  EXPECT_NE(plain, 100);
  EXPECT_EQ(corner() - 50, plain - 100);
}

TEST(ImageErrors, TheExposureWandersAsFarAndAsFastAsItIsAskedTo) {
  ImageOptions sizes = silent();
  sizes.exposure_sigma_fraction = 0.1;
  sizes.exposure_time_s = 2;
  ImageErrors errors(sizes, 1, {});
  const auto grey = [&](double t) {
    return errors.apply(cv::Mat(1, 1, CV_8UC1, cv::Scalar(100)), Stamp(std::llround(t * 1e9)))
        .at<unsigned char>(0, 0);
  };
  double squares = 0;
  constexpr int n = 1000;
  for (int i = 0; i < n; ++i) {
    squares += (grey(2.0 * i) - 100.0) * (grey(2.0 * i) - 100.0);
    EXPECT_NEAR(grey(2.0 * i + 1), (grey(2.0 * i) + grey(2.0 * i + 2)) / 2.0, 1.01);  // rounding of three
  }
  EXPECT_NEAR(std::sqrt(squares / n) / 10, 1, 0.12);  // five standard errors
}

}  // namespace
}  // namespace sim::sensor_errors
