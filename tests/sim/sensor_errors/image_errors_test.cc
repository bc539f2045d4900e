#include "sim/sensor_errors/image_errors.h"

#include <gtest/gtest.h>

#include <set>

#include "sim/sensor_errors/random.h"

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

TEST(Random, NumbersAreTheSameOnEveryMachine) {
  // Computed by a second program (Python's integers, own AS 241); a change here changes every run.
  Random random(1, "gyro noise");
  EXPECT_EQ(random.bits(), 0xc0085b38e9e26c8full);
  EXPECT_EQ(random.uniform(), 0x1.fc926265345dcp-3);
  EXPECT_EQ(random.normal(), -0x1.d49c87681a44dp-1);
}

TEST(Random, AnotherSeedNameOrItemGivesOtherNumbers) {
  std::set<std::uint64_t> first;
  for (const std::uint64_t seed : {0ull, 1ull, 2ull, ~0ull})
    for (const char* name : {"", "gyro noise", "image noise"}) {
      first.insert(Random(seed, name).bits());
      for (const std::uint64_t item : {0ull, 1ull, ~0ull}) first.insert(Random(seed, name, item).bits());
    }
  EXPECT_EQ(first.size(), 4u * 3u * 4u);
}

TEST(Random, NumbersHaveTheMomentsOfTheirDistributionsAndNoCorrelation) {
  Random random(3, "test");
  double uniform = 0, uniform2 = 0, least = 1, most = 0;
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0, serial = 0, items = 0, last = 0;
  constexpr int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform();
    uniform += x / n, uniform2 += x * x / n;
    least = std::min(least, x), most = std::max(most, x);
    const double z = random.normal();
    m1 += z / n, m2 += z * z / n, m3 += z * z * z / n, m4 += z * z * z * z / n;
    serial += z * std::exchange(last, z) / n;
    const auto item = static_cast<std::uint64_t>(i);
    items += Random(5, "test", item).normal() * Random(5, "test", item + 1).normal() / n;
  }
  EXPECT_GE(least, 0);
  EXPECT_LT(most, 1);
  // Mean and five standard errors; variances: of u, u² 1/12, 4/45, of z, z², z³, z⁴ 1, 2, 15, 96.
  for (const auto& [found, mean, variance] : {std::tuple(uniform, 0.5, 1.0 / 12),
                                              {uniform2, 1.0 / 3, 4.0 / 45},
                                              {m1, 0.0, 1.0},
                                              {m2, 1.0, 2.0},
                                              {m3, 0.0, 15.0},
                                              {m4, 3.0, 96.0},
                                              {serial, 0.0, 1.0},
                                              {items, 0.0, 1.0}})
    EXPECT_NEAR(found, mean, 5 * std::sqrt(variance / n)) << variance;
}

TEST(Random, QuantileInvertsTheDistributionFunction) {
  // The C library's erfc is the independent side: Phi(z) = erfc(−z/√2) / 2.
  for (const double p : {1e-300, 1e-100, 1e-20, 1e-11, 1e-5, 0.01, 0.0749, 0.0751, 0.3, 0.4999, 0.5}) {
    const double z = normal_quantile(p);
    // 1e-13 relative: the condition of Phi, about z², times a few roundings at |z| = 37 loses three digits.
    EXPECT_NEAR(std::erfc(-z / std::sqrt(2.0)) / 2 / p, 1, p < 1e-50 ? 1e-11 : 1e-13) << p;
  }
  EXPECT_EQ(normal_quantile(0.5), 0);
  EXPECT_EQ(normal_quantile(0.25), -normal_quantile(0.75));
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-15);
}

}  // namespace
}  // namespace sim::sensor_errors
