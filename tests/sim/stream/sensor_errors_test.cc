#include "sim/stream/sensor_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace sim::stream {
namespace {

using slam::Stamp;
using testing::HasSubstr;
using testing::ThrowsMessage;

slam::InertialSample reading(std::int64_t begin_us, std::int64_t end_us) {
  return {Stamp(begin_us * 1000), Stamp(end_us * 1000), Eigen::Vector3d(0.1, -0.2, 0.3)};
}

slam::Observation observation(int frame) {
  slam::Observation o;
  o.t = Stamp(33'000'000ll * (frame + 1));
  o.image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < 6; ++i)
    o.gyro.push_back(reading(33000 * frame + 5000 * i, 33000 * frame + 5000 * (i + 1)));
  o.accelerometer = o.gyro;
  o.plan.emplace();
  return o;
}

void expect_same(const slam::Observation& a, const slam::Observation& b) {
  ASSERT_EQ(a.gyro.size(), b.gyro.size());
  for (std::size_t i = 0; i < a.gyro.size(); ++i) EXPECT_EQ(a.gyro[i].value, b.gyro[i].value);
  ASSERT_EQ(a.image.size(), b.image.size());
  if (!a.image.empty()) {
    EXPECT_EQ(cv::norm(a.image, b.image, cv::NORM_INF), 0);
  }
  EXPECT_EQ(a.plan.has_value(), b.plan.has_value());
}

ErrorOptions none() {
  ErrorOptions options;
  options.gyro.sigma_rad_s = options.accelerometer.sigma_m_s2 = 0;
  options.image.read_sigma_grey = options.image.shot_sigma_grey = 0;
  return options;
}

TEST(SensorErrors, NoneLeaveTheObservationAsItIs) {
  const slam::Observation ideal = observation(0);
  expect_same(SensorErrors(none(), 1).apply(ideal), ideal);
}

TEST(SensorErrors, DependOnSeedAndStampNotOnWhatWasAskedBefore) {
  const SensorErrors live(ErrorOptions{}, 7), replay(ErrorOptions{}, 7), other(ErrorOptions{}, 8);
  for (int frame = 0; frame < 5; ++frame) live.apply(observation(frame));
  expect_same(live.apply(observation(5)), replay.apply(observation(5)));
  EXPECT_NE(other.apply(observation(5)).gyro[0].value, replay.apply(observation(5)).gyro[0].value);
  EXPECT_NE(replay.apply(observation(4)).gyro[0].value, replay.apply(observation(5)).gyro[0].value);
}

TEST(SensorErrors, OneDoesNotShiftTheNumbersOfAnother) {
  ErrorOptions options, lossy;
  lossy.image.loss_fraction = lossy.plan.loss_fraction = 0.5;
  lossy.accelerometer.sigma_m_s2 = 3;
  for (int frame = 0; frame < 5; ++frame)
    EXPECT_EQ(SensorErrors(options, 1).apply(observation(frame)).gyro[3].value,
              SensorErrors(lossy, 1).apply(observation(frame)).gyro[3].value);
}

TEST(SensorErrors, TheIdealImageIsNotWrittenTo) {
  const slam::Observation ideal = observation(0);
  const slam::Observation noisy = SensorErrors(ErrorOptions{}, 1).apply(ideal);
  EXPECT_NE(cv::norm(noisy.image, ideal.image, cv::NORM_INF), 0);
  EXPECT_EQ(cv::countNonZero(ideal.image != 128), 0);
}

// Standard deviation of the gyro's noise over many readings of one length, all axes.
double gyro_spread(const SensorErrors& errors, std::int64_t duration_us) {
  double sum = 0;
  constexpr int n = 20000;
  for (int i = 0; i < n; ++i) {
    slam::Observation o;
    o.gyro.push_back(reading(duration_us * i, duration_us * (i + 1)));
    sum += (errors.apply(o).gyro[0].value - reading(0, 1).value).squaredNorm();
  }
  return std::sqrt(sum / (3 * n));
}

TEST(SensorErrors, GyroNoiseOfAPartOfAReadingKeepsTheIntegralWhite) {
  const SensorErrors errors(ErrorOptions{}, 1);
  // Five standard errors of a standard deviation from 60000 numbers are 1.4 %.
  EXPECT_NEAR(gyro_spread(errors, 5000) / 0.01, 1, 0.015);
  EXPECT_NEAR(gyro_spread(errors, 2000) / (0.01 * std::sqrt(2.5)), 1, 0.015);
}

TEST(SensorErrors, BiasIsConstantOverARunAndDiffersBetweenSeeds) {
  ErrorOptions options = none();
  options.gyro.bias_sigma_rad_s = 0.01;
  const SensorErrors errors(options, 1);
  const Eigen::Vector3d ideal = reading(0, 1).value,
                        bias = errors.apply(observation(0)).gyro[0].value - ideal;
  EXPECT_GT(bias.norm(), 1e-4);
  EXPECT_EQ(errors.apply(observation(9)).gyro[5].value - ideal, bias);
  EXPECT_NE(SensorErrors(options, 2).apply(observation(0)).gyro[0].value - ideal, bias);
}

TEST(SensorErrors, ImageNoiseHasTheSpreadAskedForAtEveryGrey) {
  ErrorOptions options = none();
  options.image.read_sigma_grey = 2;
  options.image.shot_sigma_grey = 3;
  for (const int grey : {30, 128, 220}) {
    slam::Observation o;
    o.image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(grey));
    cv::Scalar mean, sd;
    cv::meanStdDev(SensorErrors(options, 1).apply(o).image, mean, sd);
    const double expected =
        std::sqrt(4 + 9.0 * grey / 255 + 1.0 / 12);  // 1/12: rounding to whole grey levels
    // Five standard errors from 76800 pixels: sigma/277*5 of the mean, 1.3 % of the spread.
    EXPECT_NEAR(mean[0], grey, 0.018 * expected);
    EXPECT_NEAR(sd[0] / expected, 1, 0.013);
  }
}

TEST(SensorErrors, ImageNoiseSaturatesInsteadOfWrapping) {
  ErrorOptions options = none();
  options.image.read_sigma_grey = 100;
  options.image.shot_sigma_grey = 50;
  for (const int grey : {0, 255}) {
    slam::Observation o;
    o.image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(grey));
    const cv::Mat noisy = SensorErrors(options, 1).apply(o).image;
    EXPECT_NEAR(cv::countNonZero(noisy == grey), 240 * 320 / 2,
                240 * 320 / 50);  // half of the noise goes outward
  }
}

TEST(SensorErrors, NeighbouringPixelsAndFramesAreUncorrelated) {
  ErrorOptions options = none();
  options.image.read_sigma_grey = 10;
  const SensorErrors errors(options, 1);
  cv::Mat a, b;
  errors.apply(observation(0)).image.convertTo(a, CV_64F, 1, -128);
  errors.apply(observation(1)).image.convertTo(b, CV_64F, 1, -128);
  const double variance = 100, n = 240 * 320;
  EXPECT_NEAR(a.dot(b) / n / variance, 0, 5 / std::sqrt(n));
  for (int shift = 1; shift <= 6; ++shift) {  // five pixels share a draw
    const cv::Mat left = a.colRange(0, 320 - shift).clone(), right = a.colRange(shift, 320).clone();
    EXPECT_NEAR(left.dot(right) / n / variance, 0, 5 / std::sqrt(n)) << shift;
  }
}

TEST(SensorErrors, LossTakesTheFractionAskedForAndOnlyThat) {
  ErrorOptions options = none();
  options.image.loss_fraction = 0.1;
  options.plan.loss_fraction = 0.3;
  const SensorErrors errors(options, 1);
  int images = 0, plans = 0, both = 0;
  constexpr int n = 2000;
  for (int frame = 0; frame < n; ++frame) {
    slam::Observation o;
    o.t = Stamp(33'000'000ll * frame);
    o.image = cv::Mat(2, 2, CV_8UC1, cv::Scalar(0));
    o.plan.emplace();
    const slam::Observation out = errors.apply(o);
    images += out.image.empty(), plans += !out.plan, both += out.image.empty() && !out.plan;
  }
  EXPECT_NEAR(images, 0.1 * n, 5 * std::sqrt(0.1 * 0.9 * n));
  EXPECT_NEAR(plans, 0.3 * n, 5 * std::sqrt(0.3 * 0.7 * n));
  EXPECT_NEAR(both, 0.03 * n, 5 * std::sqrt(0.03 * 0.97 * n));  // independent of each other
}

TEST(SensorErrors, OptionsOutOfRangeAreNamed) {
  ErrorOptions options;
  options.image.read_sigma_grey = 101;
  EXPECT_THAT([&] { SensorErrors(options, 1); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("errors.image.read_sigma_grey")));
  options = {};
  options.gyro.sigma_rad_s = std::nan("");
  EXPECT_THAT([&] { SensorErrors(options, 1); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("errors.gyro.sigma_rad_s")));
  options = {};
  options.plan.loss_fraction = 1.5;
  EXPECT_THAT([&] { SensorErrors(options, 1); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("errors.plan.loss_fraction")));
}

}  // namespace
}  // namespace sim::stream
