#include "slam/tracking_monitor.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

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
  bool blinds;
};
const std::vector<Trouble> kTroubles{
    {[](auto& m) { m.judge(kFailed); }, "tracking lost: almost no landmark found", false},
    {[](auto& m) { m.blind(kHalf, "the image is flat"); }, "tracking lost: the image is flat", true},
    {[](auto& m) { m.refuse(kHalf, "its plan is not finite"); },
     "tracking lost: observations are rejected because its plan is not finite", true}};

TEST(TrackingMonitor, TrackingIsLostAfterMoreThanTwoSecondsOfTroubleAndNamesTheCause) {
  for (const Trouble& trouble : kTroubles) {
    TrackingMonitor monitor{Options::Tracking{}};
    for (int k = 0; k < 4; ++k) trouble.happens(monitor);
    EXPECT_EQ(monitor.health(), Health::ok) << trouble.cause;
    trouble.happens(monitor);
    EXPECT_EQ(monitor.health(), Health::lost);
    EXPECT_EQ(monitor.is_blind(), trouble.blinds);
    EXPECT_EQ(monitor.cause(), trouble.cause);
    monitor.sees();
    EXPECT_EQ(monitor.health(), trouble.blinds ? Health::ok : Health::lost)
        << "only missing sight ends with sight";
    EXPECT_EQ(monitor.cause().empty(), trouble.blinds);
  }
}

TEST(TrackingMonitor, ALossEndsByRelocalizationOrAsADivergenceAfterTheTimeOfTheOptions) {
  for (const Trouble& trouble : kTroubles) {
    TrackingMonitor found{Options::Tracking{}};
    for (int k = 0; k < 5; ++k) trouble.happens(found);
    TrackingMonitor given_up = found;
    found.relocalized();
    EXPECT_EQ(found.health(), Health::ok);
    EXPECT_EQ(found.cause(), "");
    EXPECT_FALSE(found.in_doubt());
    for (int k = 0; k < 20; ++k) given_up.remains_lost(kHalf);
    EXPECT_EQ(given_up.health(), Health::lost);
    given_up.remains_lost(kHalf);
    EXPECT_EQ(given_up.health(), Health::diverged);
    EXPECT_EQ(given_up.cause(), trouble.cause + "; the map was not found again");
  }
}

TEST(TrackingMonitor, OnlyRejectedObservationsEndInADivergence) {
  TrackingMonitor monitor{Options::Tracking{}};
  for (int k = 0; k < 25; ++k) monitor.refuse(kHalf, "its plan is not finite");
  EXPECT_EQ(monitor.health(), Health::lost);
  monitor.refuse(kHalf, "its plan is not finite");
  EXPECT_EQ(monitor.health(), Health::diverged);
}

TEST(TrackingMonitor, OneGoodFrameInTwoSecondsIsEnough) {
  const std::vector<std::function<void(TrackingMonitor&)>> good{
      [](auto& m) { m.judge(kGood); }, [](auto& m) { m.sees(); }, [](auto& m) { m.accept(); }};
  for (std::size_t i = 0; i < kTroubles.size(); ++i) {
    TrackingMonitor monitor{Options::Tracking{}};
    for (int k = 0; k < 40; ++k) {
      kTroubles[i].happens(monitor);
      if (k % 3 == 0) good[i](monitor);
    }
    EXPECT_EQ(monitor.health(), Health::ok) << kTroubles[i].cause;
  }
}

TEST(TrackingMonitor, IsInDoubtAfterAFailedFrameAndNotAfterAGoodOne) {
  TrackingMonitor monitor = monitor_after(4, kFailed);
  EXPECT_TRUE(monitor.in_doubt());
  monitor.judge(kGood);
  EXPECT_FALSE(monitor.in_doubt());
}

TEST(TrackingMonitor, AnOccludedPartOfTheImageIsNotAFailure) {
  TrackingStatistics occluded = kFailed;
  occluded.coverage = 0.3;
  EXPECT_FALSE(matching_failed(occluded));
  EXPECT_TRUE(matching_failed(kFailed));
  EXPECT_EQ(monitor_after(20, occluded).health(), Health::ok);
}

TEST(TrackingMonitor, TrackingIsLostWhenTheMeanInnovationOfFifteenFramesIsTooLarge) {
  TrackingStatistics matches = kGood, height = kGood;
  matches.vision_nis = height.height_nis = 20;
  EXPECT_EQ(monitor_after(14, matches).health(), Health::ok);
  EXPECT_NE(monitor_after(15, matches).cause().find("matches are further"), std::string::npos);
  EXPECT_NE(monitor_after(15, height).cause().find("the height is further"), std::string::npos);
  matches.vision_nis = 1;
  TrackingMonitor monitor = monitor_after(100, matches);
  matches.vision_nis = 20;
  monitor.judge(matches);
  EXPECT_EQ(monitor.health(), Health::ok);  // a single outlier does not count
}

TEST(TrackingMonitor, KeepsTheFirstCauseOfADivergence) {
  TrackingMonitor monitor{Options::Tracking{}};
  monitor.diverge("first");
  monitor.diverge("second");
  EXPECT_EQ(monitor.cause(), "first");
}

TEST(Malformation, IsNamedAndAbsentInputsAreAccepted) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(malformation({}, {}), "");
  Observation whole;
  whole.image = random_blocks(320, 8, 1);
  whole.gyro = whole.accelerometer = {{Stamp(0), Stamp(5), {1, 2, 3}}};
  whole.plan = PlannedMotion{};
  EXPECT_EQ(malformation(whole, {}), "");
  const std::vector<std::pair<std::string, std::function<void(Observation&)>>> kinds{
      {"its image is not 8-bit gray of the camera's size",
       [](auto& o) { o.image = random_blocks(300, 8, 1); }},
      {"its image is not 8-bit gray of the camera's size",
       [](auto& o) { o.image = cv::Mat(240, 320, CV_8UC3, cv::Scalar(0)); }},
      {"an inertial reading is not finite", [&](auto& o) { o.accelerometer[0].value.y() = nan; }},
      {"an inertial reading is not finite", [](auto& o) { o.gyro[0].end = Stamp(-1); }},
      {"its plan is not finite", [&](auto& o) { o.plan->p_CF.x() = nan; }}};
  for (const auto& [reason, spoil] : kinds) {
    Observation o = whole;
    spoil(o);
    EXPECT_EQ(malformation(o, {}), reason);
  }
}

TEST(ImageCheck, NamesFlatAndRepeatedImages) {
  ImageCheck check;
  const cv::Mat image = random_blocks(320, 8, 1), other = random_blocks(320, 8, 2);
  const auto reason = [&](const cv::Mat& now) { return check.defect(now, false).reason; };
  EXPECT_EQ(reason(image), "");
  EXPECT_EQ(reason(image.clone()), "the image is the last one again");
  EXPECT_EQ(reason(other), "");
  EXPECT_EQ(reason(cv::Mat(240, 320, CV_8UC1, cv::Scalar(3))), "the image is flat");
  EXPECT_EQ(reason(other), "");
}

TEST(ImageCheck, FlatImagesBlindAndRepeatedOnesUnlessTheCameraIsKnownToStandStill) {
  const cv::Mat image = random_blocks(320, 8, 1);
  for (const bool still : {true, false}) {
    ImageCheck check;
    check.defect(image, still);
    for (int k = 0; k < 20; ++k) EXPECT_EQ(check.defect(image, still).blinds, !still) << k;
    EXPECT_TRUE(check.defect(cv::Mat(240, 320, CV_8UC1, cv::Scalar(0)), still).blinds);
  }
}

TEST(ImageCheck, ARepeatedImageOfACameraWithNoiseBlindsAlsoIfItStandsStill) {
  ImageCheck check;
  for (std::uint64_t k = 0; k < 6; ++k) EXPECT_EQ(check.defect(random_blocks(320, 1, k), true).reason, "");
  EXPECT_TRUE(check.defect(random_blocks(320, 1, 5), true).blinds);
}

TEST(StandsStill, IsKnownOnlyIfPlanAndGyroAgree) {
  Observation o;
  o.gyro = {{Stamp(0), Stamp(5), {0.01, 0, -0.01}}, {Stamp(5), Stamp(10), {-0.01, 0, 0.01}}};
  const PlannedInterval stands{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}}, walks{{{0.1, 0, 0}, {0, 0, 0}, {0, 0, 0}}};
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

}  // namespace
}  // namespace slam
