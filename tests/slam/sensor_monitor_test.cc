#include "slam/sensor_monitor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace slam {
namespace {

using testing::HasSubstr;

/// What a systematic error δ leaves, known with standard deviation sigma.
Evidence evidence(int which, double delta, double sigma) {
  Evidence all{};
  all[static_cast<std::size_t>(which)] = {delta / (sigma * sigma), 1 / (sigma * sigma)};
  return all;
}

SensorMonitor watch_after(int which, double delta, double sigma, const Options& options = {}) {
  SensorMonitor watch(options);
  for (int k = 0; k < 100; ++k) watch.take(evidence(which, delta, 10 * sigma), 0);  // together as sure as one of sigma
  return watch;
}

TEST(SensorMonitor, NamesAPlanThatTheInnovationsContradictByMoreThanTheBound) {
  EXPECT_EQ(watch_after(kPlanScale, 0.11, 0.01).suspect(),  // 2 % are ordinary
            "inconsistent: plan, its distances are too long by 9 standard deviations");
  EXPECT_EQ(watch_after(kPlanScale, -0.08, 0.01).suspect(),
            "inconsistent: plan, its distances are too short by 6 standard deviations");
}

TEST(SensorMonitor, NamesLegOdometryBeforeThePlanThatIsComparedWithIt) {
  SensorMonitor watch = watch_after(kLegScale, 0.11, 0.01);
  const std::string cause = "inconsistent: leg odometry, its distances are too long by 9 standard deviations";
  EXPECT_EQ(watch.suspect(), cause);
  watch.take(evidence(kPlanScale, -0.11, 0.001), 0);
  EXPECT_EQ(watch.suspect(), cause);
}

TEST(SensorMonitor, NamesImagesWhoseLensTheInnovationsContradict) {
  Options options;
  options.tracking.lens_bound = 8;
  EXPECT_EQ(
      watch_after(kLensDistortion, 0.11, 0.01, options).suspect(),
      "inconsistent: images, the distortion of the lens is said to be too large by 9 standard deviations");
  EXPECT_EQ(watch_after(kLensDistortion, 0.07, 0.01, options).suspect(), "");
}

TEST(SensorMonitor, IsSilentBelowItAndWithoutEvidence) {
  EXPECT_EQ(SensorMonitor(Options{}).suspect(), "");
  EXPECT_EQ(watch_after(kPlanScale, 0.059, 0.01).suspect(), "");
  EXPECT_EQ(watch_after(kPlanScale, -0.4, 0.1).suspect(), "");
}

TEST(SensorMonitor, TheBoundIsAnOption) {
  Options options;
  options.tracking.plan_bound = 3;
  EXPECT_EQ(watch_after(kPlanScale, 0.055, 0.01).suspect(), "");
  EXPECT_NE(watch_after(kPlanScale, 0.055, 0.01, options).suspect(), "");
}

TEST(SensorMonitor, ASmallErrorOfThePlanDoesNotBecomeCertainOnALongWalk) {
  SensorMonitor watch{Options{}};
  for (int frame = 0; frame < 30 * 900; ++frame) {  // in 30 s the error is known within 0.014
    watch.take(evidence(kPlanScale, 0.035, 0.014 * 30), 1.0 / 30);
    ASSERT_EQ(watch.suspect(), "") << frame / 30.0 << " s";
  }
  EXPECT_GT(watch.sigmas(kPlanScale), 0.5);
}

TEST(SensorMonitor, IsSilentAboutThePlanWhereNoOtherSensorKnowsTheMetre) {
  Options options;
  options.accelerometer.enabled = false;
  EXPECT_EQ(watch_after(kPlanScale, 0.2, 0.01, options).suspect(), "");
}

TEST(SensorMonitor, AddsUpAllEvidenceAndForgetsItWhenReset) {
  SensorMonitor watch{Options{}};
  watch.take(evidence(kPlanScale, 0.1, 0.02), 0);
  watch.take(evidence(kPlanScale, 0.3, 0.02), 0);
  EXPECT_NEAR(watch.sigmas(kPlanScale), (0.2 - 0.02) / (0.02 / 1.4142135623730951), 1e-12);
  watch.reset();
  EXPECT_EQ(watch.sigmas(kPlanScale), 0);
}

/// Readings of 5 ms with noise, while the sensor turns to and fro by 0.5 rad/s and feet land with impacts of 2 rad/s.
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

TEST(GyroNoiseTest, FindsTwiceTheNoiseWithinThreeSecondsAndAccusesNoSoundGyro) {
  const Options::Gyro options;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    GyroNoiseTest sound(options), noisy(options);
    for (const InertialSample& reading : noisy_readings(options.sigma_rad_s, 60, seed)) {
      sound.take({reading});
      EXPECT_FALSE(sound.scatters()) << seed << ", " << seconds(reading.end) << " s";
    }
    noisy.take(noisy_readings(2 * options.sigma_rad_s, 3, seed));
    EXPECT_TRUE(noisy.scatters()) << seed;
  }
}

TEST(GyroNoiseTest, ReadingsThatAFrameSplitsAreNotCompared) {
  GyroNoiseTest watch{Options::Gyro{}};
  std::vector<InertialSample> split = noisy_readings(1, 60, 1);
  for (std::size_t i = 0; i < split.size(); i += 2) split[i].begin += std::chrono::milliseconds(1);
  watch.take(split);
  EXPECT_FALSE(watch.scatters());
}

TEST(ImageTest, FailsWhereLandmarksAreNotFoundAndDeletedAgain) {
  ImageTest sound, foreign, dark;
  for (int frame = 0; frame < 100; ++frame) {
    sound.take(0.033, 12, 10, frame % 50 == 0);
    foreign.take(0.033, 12, 5, frame % 10 == 0);
    dark.take(0.033, 12, 1, 0);
  }
  EXPECT_FALSE(sound.fails());
  EXPECT_TRUE(foreign.fails());
  EXPECT_FALSE(dark.fails());  // nothing is found, and no landmark is blamed for it
}

/// Whether the watch fails after tracking was lost in these frames of 300 at 30 Hz, of which all from `dark` on are no good.
bool fails_after(const std::vector<std::pair<int, int>>& losses, int dark = 300) {
  ImageTest watch;
  for (int frame = 0; frame < 300; ++frame) {
    bool lost = false;
    for (const auto& [from, to] : losses) lost = lost || (frame >= from && frame < to);
    watch.take_health(1.0 / 30, lost, frame < dark);
    if (watch.fails()) return true;
  }
  return false;
}

TEST(ImageTest, FailsWhereTrackingIsLostForLongOrTwiceAlthoughTheImagesAreGood) {
  EXPECT_FALSE(fails_after({{100, 115}}));
  EXPECT_TRUE(fails_after({{100, 140}}));
  EXPECT_TRUE(fails_after({{100, 103}, {200, 203}}));
  EXPECT_FALSE(fails_after({{100, 290}}, 90));  // the loss began with an image that is no good
}

TEST(SensorMonitor, NamesGyroBeforeImagesBeforePlan) {
  SensorMonitor watch = watch_after(kPlanScale, 0.09, 0.01);
  for (int frame = 0; frame < 100; ++frame) watch.images().take(0.033, 12, 5, frame % 10 == 0);
  EXPECT_THAT(watch.suspect(), HasSubstr("inconsistent: images, landmarks"));
  watch.gyro().take(noisy_readings(1, 5, 1));
  EXPECT_THAT(watch.suspect(), HasSubstr("inconsistent: gyro"));
}

}  // namespace
}  // namespace slam
