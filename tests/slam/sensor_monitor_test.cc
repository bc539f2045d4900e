#include "slam/sensor_monitor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace slam {
namespace {

using testing::HasSubstr;

/// The evidence of a systematic error δ, known with standard deviation sigma.
Evidence evidence(int which, double delta, double sigma) {
  Evidence all{};
  all[static_cast<std::size_t>(which)] = {delta / (sigma * sigma), 1 / (sigma * sigma)};
  return all;
}

SensorMonitor monitor_after(int which, double delta, double sigma, const Options& options = {}) {
  SensorMonitor monitor(options);
  for (int k = 0; k < 100; ++k)
    monitor.add(evidence(which, delta, 10 * sigma), 0);  // together as certain as one of sigma
  return monitor;
}

TEST(SensorMonitor, NamesASensorThatTheInnovationsContradictByMoreThanTheBound) {
  Options strict, no_scale;
  strict.tracking.plan_bound = 3, strict.tracking.lens_bound = 8;
  no_scale.accelerometer.enabled = false;  // no other sensor measures the scale
  const std::string plan = "inconsistent: plan, its distances are too ", by = " standard deviations";
  const std::vector<std::tuple<int, double, double, Options, std::string>> cases{
      {kPlanScale, 0.11, 0.01, {}, plan + "long by 9" + by},  // 2 % are ordinary
      {kPlanScale, -0.08, 0.01, {}, plan + "short by 6" + by},
      {kPlanScale, 0.059, 0.01, {}, ""},
      {kPlanScale, -0.4, 0.1, {}, ""},
      {kPlanScale, 0.055, 0.01, {}, ""},
      {kPlanScale, 0.055, 0.01, strict, plan + "long by 4" + by},
      {kPlanScale, 0.2, 0.01, no_scale, ""},
      {kLegScale, 0.11, 0.01, {}, "inconsistent: leg odometry, its distances are too long by 9" + by},
      {kLensDistortion, 0.11, 0.01, strict,
       "inconsistent: images, the assumed distortion of the lens is too large by 9" + by},
      {kLensDistortion, 0.07, 0.01, strict, ""}};
  for (const auto& [which, delta, sigma, options, suspect] : cases)
    EXPECT_EQ(monitor_after(which, delta, sigma, options).suspect(), suspect) << which << ' ' << delta;
  EXPECT_EQ(SensorMonitor(Options{}).suspect(), "");
}

TEST(SensorMonitor, NamesLegOdometryBeforeThePlanThatIsComparedWithIt) {
  SensorMonitor monitor = monitor_after(kLegScale, 0.11, 0.01);
  monitor.add(evidence(kPlanScale, -0.11, 0.001), 0);
  EXPECT_THAT(monitor.suspect(), HasSubstr("inconsistent: leg odometry"));
}

TEST(SensorMonitor, ASmallErrorOfThePlanDoesNotBecomeCertainOnALongWalk) {
  SensorMonitor monitor{Options{}};
  for (int frame = 0; frame < 30 * 900; ++frame) {  // in 30 s the error is known within 0.014
    monitor.add(evidence(kPlanScale, 0.035, 0.014 * 30), 1.0 / 30);
    ASSERT_EQ(monitor.suspect(), "") << frame / 30.0 << " s";
  }
  EXPECT_GT(monitor.sigmas(kPlanScale), 0.5);
}

TEST(SensorMonitor, AddsUpAllEvidenceAndForgetsItWhenReset) {
  SensorMonitor monitor{Options{}};
  monitor.add(evidence(kPlanScale, 0.1, 0.02), 0);
  monitor.add(evidence(kPlanScale, 0.3, 0.02), 0);
  EXPECT_NEAR(monitor.sigmas(kPlanScale), (0.2 - 0.02) / (0.02 / 1.4142135623730951), 1e-12);
  monitor.reset();
  EXPECT_EQ(monitor.sigmas(kPlanScale), 0);
}

/// Readings of 5 ms with noise, while the sensor turns to and fro by 0.5 rad/s and feet land with impacts of
/// 2 rad/s.
std::vector<InertialSample> noisy_readings(double sigma, double seconds_, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sigma);
  std::vector<InertialSample> all;
  for (int i = 0; i < static_cast<int>(200 * seconds_); ++i) {
    const Stamp begin = std::chrono::milliseconds(5 * i);
    const double turn = 0.5 * std::sin(2 * 3.14159 * 0.005 * i / 1.6) + (i % 160 == 0 ? 2 : 0);
    all.push_back({begin, begin + std::chrono::milliseconds(5),
                   Eigen::Vector3d(turn + normal(random), normal(random), normal(random))});
  }
  return all;
}

TEST(GyroNoiseTest, FindsTwiceTheNoiseWithinThreeSecondsWithoutFalsePositives) {
  const Options::Gyro options;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    GyroNoiseTest sound(options), noisy(options);
    for (const InertialSample& reading : noisy_readings(options.sigma_rad_s, 60, seed)) {
      sound.add({reading});
      EXPECT_FALSE(sound.scatters()) << seed << ", " << seconds(reading.end) << " s";
    }
    noisy.add(noisy_readings(2 * options.sigma_rad_s, 3, seed));
    EXPECT_TRUE(noisy.scatters()) << seed;
  }
}

TEST(GyroNoiseTest, ReadingsThatAFrameSplitsAreNotCompared) {
  GyroNoiseTest monitor{Options::Gyro{}};
  std::vector<InertialSample> split = noisy_readings(1, 60, 1);
  for (std::size_t i = 0; i < split.size(); i += 2) split[i].begin += std::chrono::milliseconds(1);
  monitor.add(split);
  EXPECT_FALSE(monitor.scatters());
}

TEST(ImageTest, FailsWhereLandmarksAreNotFoundAndDeletedAgain) {
  ImageTest sound, other, dark;
  for (int frame = 0; frame < 100; ++frame) {
    sound.add(0.033, 12, 10, frame % 50 == 0);
    other.add(0.033, 12, 5, frame % 10 == 0);
    dark.add(0.033, 12, 1, 0);
  }
  EXPECT_FALSE(sound.fails());
  EXPECT_TRUE(other.fails());
  EXPECT_FALSE(dark.fails());  // nothing is found, and no landmark is blamed for it
}

/// True if the test fails after losses in these frames of 300 at 30 Hz; the images from `dark` on are bad.
bool fails_after(const std::vector<std::pair<int, int>>& losses, int dark = 300) {
  ImageTest monitor;
  for (int frame = 0; frame < 300; ++frame) {
    bool lost = false;
    for (const auto& [from, to] : losses) lost = lost || (frame >= from && frame < to);
    monitor.add_health(1.0 / 30, lost, frame < dark);
    if (monitor.fails()) return true;
  }
  return false;
}

TEST(ImageTest, FailsWhereTrackingIsLostForLongOrTwiceAlthoughTheImagesAreGood) {
  EXPECT_FALSE(fails_after({{100, 115}}));
  EXPECT_TRUE(fails_after({{100, 140}}));
  EXPECT_TRUE(fails_after({{100, 103}, {200, 203}}));
  EXPECT_FALSE(fails_after({{100, 290}}, 90));  // the loss started with a bad image
}

TEST(SensorMonitor, NamesGyroBeforeImagesBeforePlan) {
  SensorMonitor monitor = monitor_after(kPlanScale, 0.09, 0.01);
  for (int frame = 0; frame < 100; ++frame) monitor.images().add(0.033, 12, 5, frame % 10 == 0);
  EXPECT_THAT(monitor.suspect(), HasSubstr("inconsistent: images, landmarks"));
  monitor.gyro().add(noisy_readings(1, 5, 1));
  EXPECT_THAT(monitor.suspect(), HasSubstr("inconsistent: gyro"));
}

}  // namespace
}  // namespace slam
