#include "sim/sensor_errors/image_errors.h"

#include <gtest/gtest.h>

namespace sim::sensor_errors {
namespace {

using slam::Stamp;

ImageOptions noise(double read, double shot, double gain = 1) {
  ImageOptions sizes;
  sizes.read_sigma_grey = read, sizes.shot_sigma_grey = shot, sizes.gain = gain;
  return sizes;
}

cv::Mat received(const ImageOptions& sizes, int grey, Stamp t = Stamp(1)) {
  return ImageErrors(sizes, 1, {}).apply(cv::Mat(240, 320, CV_8UC1, cv::Scalar(grey)), t);
}

TEST(ImageErrors, NoiseHasTheSpreadAskedForAtEveryGreyAndGain) {
  for (const auto& [grey, gain] : {std::pair(30, 1.0), {128, 1.0}, {220, 1.0}, {40, 4.0}}) {
    cv::Scalar mean, sigma;
    cv::meanStdDev(received(noise(2, 3, gain), grey), mean, sigma);
    const double expected = std::sqrt(gain * gain * (4 + 9.0 * grey / 255) + 1.0 / 12);  // and rounding
    EXPECT_NEAR(mean[0], gain * grey, 0.018 * expected);  // five standard errors of 76800 pixels
    EXPECT_NEAR(sigma[0] / expected, 1, 0.013);
  }
}

TEST(ImageErrors, NoiseSaturatesInsteadOfWrapping) {
  for (const int grey : {0, 255})  // half of the noise goes outward
    EXPECT_NEAR(cv::countNonZero(received(noise(100, 50), grey) == grey), 240 * 320 / 2, 240 * 320 / 50);
}

TEST(ImageErrors, NeighboringPixelsAndFramesAreUncorrelated) {
  cv::Mat a, b;
  received(noise(10, 0), 128, Stamp(1)).convertTo(a, CV_64F, 1, -128);
  received(noise(10, 0), 128, Stamp(2)).convertTo(b, CV_64F, 1, -128);
  const double variance = 100, n = 240 * 320;
  EXPECT_NEAR(a.dot(b) / n / variance, 0, 5 / std::sqrt(n));
  for (int shift = 1; shift <= 6; ++shift) {  // five pixels share a draw
    const cv::Mat left = a.colRange(0, 320 - shift).clone(), right = a.colRange(shift, 320).clone();
    EXPECT_NEAR(left.dot(right) / n / variance, 0, 5 / std::sqrt(n)) << shift;
  }
}

TEST(ImageErrors, VignettingTakesItsFractionInTheCornersAndNothingInTheMiddle) {
  ImageOptions sizes = noise(0, 0);
  sizes.vignetting_fraction = 0.5;
  const cv::Mat image = received(sizes, 200);
  EXPECT_EQ(image.at<unsigned char>(120, 160), 200);
  EXPECT_EQ(image.at<unsigned char>(0, 0), 100);
  EXPECT_EQ(image.at<unsigned char>(239, 319), 100);
  // Half-way to a corner a quarter of it is lost: 200 (1 - 0.5 / 4).
  EXPECT_NEAR(image.at<unsigned char>(60, 80), 175, 1);
}

TEST(ImageErrors, VignettingDarkensTheLightAndNotTheNoiseOfReadingIt) {
  ImageOptions sizes = noise(5, 0);
  const int plain = received(sizes, 100).at<unsigned char>(0, 0);
  sizes.vignetting_fraction = 0.5;
  EXPECT_NE(plain, 100);
  EXPECT_EQ(received(sizes, 100).at<unsigned char>(0, 0) - 50, plain - 100);
}

}  // namespace
}  // namespace sim::sensor_errors
