#include "slam/monitors.h"

#include "tests/slam/test_scenes.h"

namespace slam {
namespace {

const TrackingStatistics kFailed{0.5, 12, 1, 1, {}, {}}, kGood{0.5, 12, 10, 1, {}, {}};
constexpr Stamp kHalf = std::chrono::milliseconds(500);

TrackingMonitor monitor_after(int frames, const TrackingStatistics& statistics) {
  TrackingMonitor monitor{Options::Tracking{}};
  for (int k = 0; k < frames; ++k) monitor.judge(statistics);
  return monitor;
}

/// An event of half a second that leads to a loss, and the cause of the loss.
struct Trouble {
  std::function<void(TrackingMonitor&)> happens;
  std::string cause;
};
const std::vector<Trouble> kTroubles{
    {[](auto& m) { m.judge(kFailed); }, "tracking lost: almost no landmarks were found"},
    {[](auto& m) { m.blind(kHalf, "the image is flat"); }, "tracking lost: the image is flat"},
    {[](auto& m) { m.refuse(kHalf, "the plan is not finite"); },
     "tracking lost: observations are rejected because the plan is not finite"}};

TEST(TrackingMonitor, ALossAfterTwoSecondsStatesItsCauseAndEndsByRelocalizationOrInDivergence) {
  for (const Trouble& trouble : kTroubles) {
    TrackingMonitor monitor{Options::Tracking{}};
    for (int k = 0; k < 4; ++k) trouble.happens(monitor);
    EXPECT_EQ(monitor.health(), Health::ok) << trouble.cause;
    trouble.happens(monitor);
    EXPECT_EQ(monitor.health(), Health::lost);
    EXPECT_TRUE(monitor.is_blind());
    EXPECT_EQ(monitor.cause(), trouble.cause);
    EXPECT_EQ(monitor.in_doubt(), &trouble == kTroubles.data());
    TrackingMonitor given_up = monitor, found = monitor;
    monitor.sees();
    EXPECT_EQ(monitor.health(), Health::ok);
    EXPECT_FALSE(monitor.cause());
    found.relocalized();
    EXPECT_EQ(found.health(), Health::ok);
    EXPECT_FALSE(found.cause());
    EXPECT_FALSE(found.in_doubt());
    for (int k = 0; k < 20; ++k) given_up.remains_lost(kHalf);
    EXPECT_EQ(given_up.health(), Health::lost);
    given_up.remains_lost(kHalf);
    EXPECT_EQ(given_up.health(), Health::diverged);
    given_up.diverge("another cause");
    EXPECT_EQ(given_up.cause(), trouble.cause + "; the map was not found again");
  }
}

TEST(TrackingMonitor, ALossByContradictionDoesNotEndWithSight) {
  TrackingStatistics contradicted = kGood;
  contradicted.vision_nis = 20;
  TrackingMonitor monitor = monitor_after(15, contradicted);
  EXPECT_FALSE(monitor.is_blind());
  monitor.sees();
  EXPECT_EQ(monitor.health(), Health::lost);
}

TEST(TrackingMonitor, ALostFilterKnowsWhetherMatchingFailedInTheLastFrame) {
  TrackingMonitor monitor = monitor_after(5, kFailed);
  EXPECT_EQ(monitor.health(), Health::lost);
  EXPECT_TRUE(monitor.in_doubt());
  monitor.judge(kGood);
  EXPECT_FALSE(monitor.in_doubt());
  EXPECT_EQ(monitor.health(), Health::lost);
}

TEST(TrackingMonitor, OnlyRejectedObservationsEndInADivergence) {
  TrackingMonitor monitor{Options::Tracking{}};
  for (int k = 0; k < 25; ++k) monitor.refuse(kHalf, "the plan is not finite");
  EXPECT_EQ(monitor.health(), Health::lost);
  monitor.refuse(kHalf, "the plan is not finite");
  EXPECT_EQ(monitor.health(), Health::diverged);
}

TEST(TrackingMonitor, OneGoodFrameInTwoSecondsIsEnough) {
  const std::vector<std::function<void(TrackingMonitor&)>> good{[](auto& m) {
                                                                  for (int k = 0; k < 3; ++k) m.judge(kGood);
                                                                },
                                                                [](auto& m) { m.sees(); },
                                                                [](auto& m) { m.accept(); }};
  for (std::size_t i = 0; i < kTroubles.size(); ++i) {
    TrackingMonitor monitor{Options::Tracking{}};
    for (int k = 0; k < 40; ++k) {
      kTroubles[i].happens(monitor);
      if (k % 3 == 0) good[i](monitor);
    }
    EXPECT_EQ(monitor.health(), Health::ok) << kTroubles[i].cause;
  }
}

TEST(TrackingMonitor, ASingleGoodFrameDoesNotOutweighManyWithoutMatches) {
  TrackingMonitor monitor{Options::Tracking{}};
  for (int k = 0; k < 12; ++k) monitor.judge(k % 4 == 3 ? kGood : kFailed);
  EXPECT_EQ(monitor.health(), Health::lost);
}

TEST(TrackingMonitor, SightAfterALossForgetsEarlierFailures) {
  TrackingMonitor monitor = monitor_after(4, kFailed);
  for (int k = 0; k < 5; ++k) monitor.blind(kHalf, "the image is flat");
  monitor.sees();
  monitor.judge(kFailed);
  EXPECT_EQ(monitor.health(), Health::ok);
}

TEST(TrackingMonitor, WithoutSightItIsLostOnceThePoseIsUncertainAndGivesUpNoSooner) {
  TrackingMonitor monitor{Options::Tracking{}};
  monitor.blind(kHalf, "no image arrives", true);
  EXPECT_EQ(monitor.health(), Health::ok);
  monitor.blind(kHalf, "no image arrives", false);
  EXPECT_EQ(monitor.health(), Health::lost);
  int frames = 0;
  for (; monitor.health() == Health::lost; ++frames) {
    monitor.blind(kHalf, "no image arrives", false);
    monitor.remains_lost(kHalf);
  }
  EXPECT_EQ(frames, 3 + 20);  // 2 s without images have passed, and 10 s more
}

TEST(TrackingMonitor, AnOccludedPartOfTheImageIsNotAFailure) {
  TrackingStatistics occluded = kFailed;
  occluded.coverage = 0.3;
  EXPECT_EQ(monitor_after(20, occluded).health(), Health::ok);
}

TEST(TrackingMonitor, TrackingIsLostWhenTheMeanInnovationOfFifteenFramesIsTooLarge) {
  TrackingStatistics matches = kGood, height = kGood;
  matches.vision_nis = height.height_nis = 20;
  EXPECT_EQ(monitor_after(14, matches).health(), Health::ok);
  EXPECT_NE(monitor_after(15, matches).cause().value().find("matches are further"), std::string::npos);
  EXPECT_NE(monitor_after(15, height).cause().value().find("the height is further"), std::string::npos);
  matches.vision_nis = 1;
  TrackingMonitor monitor = monitor_after(100, matches);
  matches.vision_nis = 20;
  monitor.judge(matches);
  EXPECT_EQ(monitor.health(), Health::ok);  // a single outlier does not count
}

TEST(ImageCheck, FlatImagesBlindAndSoDoRepeatedOnesUnlessTheCameraStandsStill) {
  const cv::Mat image = random_blocks(320, 8, 1);
  for (const bool still : {true, false}) {
    ImageCheck check;
    check.defect(image, still);
    for (int k = 0; k < 20; ++k) EXPECT_EQ(check.defect(image, still).value().blinds, !still) << k;
    EXPECT_TRUE(check.defect(cv::Mat(240, 320, CV_8UC1, cv::Scalar(0)), still).value().blinds);
  }
}

TEST(ImageCheck, ALowContrastImageIsNotFlatIfAPatchOfItCanBeTracked) {
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(120));
  EXPECT_TRUE(ImageCheck().defect(image, false).value().blinds);
  image(cv::Rect(100, 80, 4, 4)) = 200;  // the whole image has a standard deviation of 1.2
  EXPECT_FALSE(ImageCheck().defect(image, false));
}

TEST(ImageCheck, ARepeatedImageOfANoisyCameraBlindsEvenIfItStandsStill) {
  ImageCheck check;
  for (std::uint64_t k = 0; k < 6; ++k) EXPECT_FALSE(check.defect(random_blocks(320, 1, k), true));
  EXPECT_TRUE(check.defect(random_blocks(320, 1, 5), true).value().blinds);
}

TEST(StandsStill, IsKnownOnlyIfPlanAndGyroAgree) {
  Observation o;
  o.gyro = {{Stamp(0), Stamp(5), {0.01, 0, -0.01}}, {Stamp(5), Stamp(10), {-0.01, 0, 0.01}}};
  const PlannedVelocity still{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const PlannedInterval stands{still, true}, walks{still, false};
  Options without_plan, without_gyro;
  without_plan.plan_velocity.enabled = without_gyro.gyro.enabled = false;
  EXPECT_TRUE(stands_still(o, stands, {}));
  EXPECT_FALSE(stands_still(o, walks, {}));
  EXPECT_FALSE(stands_still(o, std::nullopt, {}));
  EXPECT_FALSE(stands_still(o, stands, without_plan));
  EXPECT_FALSE(stands_still(o, stands, without_gyro));
  for (InertialSample& reading : o.gyro) reading.value.y() = 0.2;
  EXPECT_FALSE(stands_still(o, stands, {}));
  o.gyro.clear();
  EXPECT_FALSE(stands_still(o, stands, {}));
}

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
    monitor.add(evidence(which, delta, 10 * sigma), 0);  // together as precise as a single value with sigma
  return monitor;
}

TEST(SensorMonitor, NamesASensorThatTheInnovationsContradictByMoreThanTheBound) {
  Options strict, no_scale;
  strict.tracking.plan_bound = 3, strict.tracking.lens_bound = 8;
  no_scale.accelerometer.enabled = false;  // no other sensor measures the scale
  const std::string plan = "inconsistent: plan, its distances are too ", by = " standard deviations";
  const std::vector<std::tuple<int, double, double, Options, std::optional<std::string>>> cases{
      {kPlanScale, 0.11, 0.01, {}, plan + "long by 9" + by},  // 2 % are ordinary
      {kPlanScale, -0.08, 0.01, {}, plan + "short by 6" + by},
      {kPlanScale, 0.059, 0.01, {}, std::nullopt},
      {kPlanScale, -0.4, 0.1, {}, std::nullopt},
      {kPlanScale, 0.055, 0.01, {}, std::nullopt},
      {kPlanScale, 0.055, 0.01, strict, plan + "long by 4" + by},
      {kPlanScale, 0.2, 0.01, no_scale, std::nullopt},
      {kLegScale, 0.11, 0.01, {}, "inconsistent: leg odometry, its distances are too long by 9" + by},
      {kLensDistortion, 0.11, 0.01, strict,
       "inconsistent: images, the assumed distortion of the lens is too large by 9" + by},
      {kLensDistortion, 0.07, 0.01, strict, std::nullopt}};
  for (const auto& [which, delta, sigma, options, suspect] : cases)
    EXPECT_EQ(monitor_after(which, delta, sigma, options).suspect(), suspect) << which << ' ' << delta;
  EXPECT_FALSE(SensorMonitor(Options{}).suspect());
}

TEST(SensorMonitor, ASmallPlanErrorDoesNotBecomeSignificantOnALongWalkAndIsForgottenOnReset) {
  SensorMonitor monitor{Options{}};
  for (int frame = 0; frame < 30 * 900; ++frame) {  // in 30 s the error is known within 0.014
    monitor.add(evidence(kPlanScale, 0.035, 0.014 * 30), 1.0 / 30);
    ASSERT_FALSE(monitor.suspect()) << frame / 30.0 << " s";
  }
  EXPECT_GT(monitor.sigmas(kPlanScale), 0.5);
  monitor.reset();
  EXPECT_EQ(monitor.sigmas(kPlanScale), 0);
}

/// Readings of 5 ms with noise while the sensor turns back and forth by 0.5 rad/s, with impacts of 2 rad/s.
std::vector<InertialSample> noisy_readings(double sigma, double seconds_, std::uint64_t seed) {
  Normal normal(seed);
  std::vector<InertialSample> all;
  for (int i = 0; i < static_cast<int>(200 * seconds_); ++i) {
    const Stamp begin = std::chrono::milliseconds(5 * i);
    const double turn = 0.5 * std::sin(2 * 3.14159 * 0.005 * i / 1.6) + (i % 160 == 0 ? 2 : 0);
    const Eigen::Vector3d noise = sigma * random_matrix(3, 1, normal);
    all.push_back({begin, begin + std::chrono::milliseconds(5), Eigen::Vector3d(turn, 0, 0) + noise});
  }
  return all;
}

TEST(GyroNoiseTest, DetectsTwiceTheNoiseWithinThreeSecondsWithoutFalsePositives) {
  const Options::Gyro options;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    GyroNoiseTest sound(options), noisy(options);
    for (const InertialSample& reading : noisy_readings(options.sigma_rad_s, 60, seed)) {
      sound.add({reading});
      EXPECT_FALSE(sound.scatters()) << seed << ", " << seconds(reading.end) << " s";
    }
    noisy.add(noisy_readings(2 * options.sigma_rad_s, 3, seed));
    EXPECT_TRUE(noisy.scatters()) << seed;
  }
}

TEST(GyroNoiseTest, AShakingRobotIsNotNoise) {
  const Options::Gyro options;
  GyroNoiseTest shaking(options), noisy(options);
  for (auto [test, sigma] : {std::pair{&shaking, options.sigma_rad_s}, {&noisy, 10 * options.sigma_rad_s}}) {
    for (const double hz : {20, 40}) {
      std::vector<InertialSample> readings = noisy_readings(sigma, 10, 1);
      for (InertialSample& reading : readings)
        reading.value.array() += 3 / hz * std::sin(2 * 3.14159 * hz * seconds(reading.end));
      test->add(readings);
      EXPECT_EQ(test->scatters(), test == &noisy) << hz;
    }
  }
}

TEST(GyroNoiseTest, ReadingsSplitByAFrameAreNotCompared) {
  GyroNoiseTest monitor{Options::Gyro{}};
  std::vector<InertialSample> split = noisy_readings(1, 60, 1);
  for (std::size_t i = 0; i < split.size(); i += 2) split[i].begin += std::chrono::milliseconds(1);
  monitor.add(split);
  EXPECT_FALSE(monitor.scatters());
}

TEST(TurnTest, FailsIfTheGyroTurnsDifferentlyFromTheLegsForSomeSeconds) {
  const double dt_s = 1.0 / 30;
  TurnTest slipping, stuck;
  for (int frame = 0; frame < 90; ++frame) {  // 3 s
    slipping.add(dt_s, 0.04 * dt_s);          // soles that slip by 2.3 degrees a second
    stuck.add(dt_s, 0.26 * dt_s);             // a circle of 0.75 m at 0.2 m/s
    EXPECT_FALSE(slipping.fails());
  }
  EXPECT_TRUE(stuck.fails());
  for (int frame = 0; frame < 300; ++frame) stuck.add(dt_s, 0);
  EXPECT_FALSE(stuck.fails());
}

TEST(ImageTest, FailsIfLandmarksAreNotFoundAndAreDeletedAgain) {
  ImageTest sound, other, dark;
  for (int frame = 0; frame < 100; ++frame) {
    sound.add(0.033, 12, 10, frame % 50 == 0);
    other.add(0.033, 12, 5, frame % 10 == 0);
    dark.add(0.033, 12, 1, 0);
  }
  EXPECT_FALSE(sound.fails());
  EXPECT_TRUE(other.fails());
  EXPECT_FALSE(dark.fails());  // nothing is found, but the landmarks do not count as unreliable
}

/// True if the test fails after losses in these of 300 frames at 30 Hz. Images starting at frame `dark` are
/// bad.
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

TEST(ImageTest, FailsIfTrackingIsLostForLongOrThreeTimesDespiteGoodImages) {
  EXPECT_FALSE(fails_after({{100, 115}}));
  EXPECT_TRUE(fails_after({{100, 140}}));
  EXPECT_FALSE(fails_after({{100, 103}, {200, 203}}));  // each time, the map was found again
  EXPECT_TRUE(fails_after({{100, 103}, {150, 153}, {200, 203}}));
  EXPECT_FALSE(fails_after({{100, 290}}, 90));  // the loss started with a bad image
}

TEST(InnovationTest, FailsIfTheMeanOfSecondsIsTooLargeButNotAfterAFewFrames) {
  for (const auto& [nis, fails] : {std::pair(1.4, false), {1.6, true}}) {
    InnovationTest test(1.5);
    for (int frame = 0; frame < 25; ++frame) test.add(1.0 / 30, Nis{3 * 10.0, 3});
    EXPECT_FALSE(test.fails());
    for (int frame = 0; frame < 1000; ++frame) {
      test.add(1.0 / 30, std::nullopt);
      test.add(1.0 / 30, Nis{3 * nis, 3});
    }
    EXPECT_EQ(test.fails(), fails) << nis;
  }
}

TEST(SensorMonitor, NamesTheSensorWhoseInnovationsAreTooLargeBeforeTheLegsScale) {
  SensorMonitor monitor = monitor_after(kLegScale, 0.11, 0.01);
  const auto after = [&](InnovationTest& test) {
    for (int frame = 0; frame < 100; ++frame) test.add(1.0 / 30, Nis{12, 3});
    return monitor.suspect().value();
  };
  EXPECT_EQ(after(monitor.legs()), "inconsistent: leg odometry, its velocities scatter more than assumed");
  EXPECT_EQ(after(monitor.height()), "inconsistent: height, the floor is not level");
  EXPECT_EQ(after(monitor.matches()), "inconsistent: images, their matches scatter more than assumed");
  monitor.reset();
  EXPECT_FALSE(monitor.suspect());
}

TEST(SensorMonitor, NamesGyroThenImagesThenLegOdometryThenThePlanComparedWithIt) {
  SensorMonitor monitor = monitor_after(kPlanScale, 0.09, 0.01);
  monitor.add(evidence(kLegScale, 0.11, 0.001), 0);
  EXPECT_THAT(monitor.suspect().value(), HasSubstr("inconsistent: leg odometry"));
  for (int frame = 0; frame < 100; ++frame) monitor.images().add(0.033, 12, 5, frame % 10 == 0);
  EXPECT_THAT(monitor.suspect().value(), HasSubstr("inconsistent: images, landmarks"));
  monitor.gyro().add(noisy_readings(1, 5, 1));
  EXPECT_THAT(monitor.suspect().value(), HasSubstr("inconsistent: gyro"));
}

}  // namespace
}  // namespace slam
