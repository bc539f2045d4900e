#include "slam/tracking_monitor.h"

#include <gtest/gtest.h>

#include <chrono>

namespace slam {
namespace {

const TrackingStatistics kFailed{0.5, 12, 1, 1, {}, {}}, kGood{0.5, 12, 10, 1, {}, {}};

constexpr Stamp kHalf = std::chrono::milliseconds(500);

/// A watch after `frames` frames of the given statistics.
TrackingMonitor after(int frames, const TrackingStatistics& statistics, const Options::Tracking& options = {}) {
  TrackingMonitor watch(options);
  for (int k = 0; k < frames; ++k) watch.judge(statistics);
  return watch;
}

TEST(TrackingMonitor, TrackingIsLostAfterTwoSecondsOfFailedMatching) {
  TrackingMonitor watch = after(4, kFailed);
  EXPECT_EQ(watch.health(), Health::ok);
  EXPECT_TRUE(watch.in_doubt());
  watch.judge(kFailed);
  EXPECT_EQ(watch.health(), Health::lost);
  EXPECT_EQ(watch.cause(), "tracking lost: almost no landmark found");
}

TEST(TrackingMonitor, OneGoodFrameEndsTheDoubt) {
  TrackingMonitor watch = after(4, kFailed);
  watch.judge(kGood);
  EXPECT_FALSE(watch.in_doubt());
  watch.judge(kFailed);
  EXPECT_EQ(watch.health(), Health::ok);
}

TEST(TrackingMonitor, AnOccludedPartOfTheImageIsNoFailure) {
  TrackingStatistics occluded = kFailed;
  occluded.coverage = 0.3;
  EXPECT_FALSE(matching_failed(occluded));
  EXPECT_TRUE(matching_failed(kFailed));
  EXPECT_EQ(after(20, occluded).health(), Health::ok);
}

TEST(TrackingMonitor, TrackingIsLostWhenTheMeanInnovationOfFifteenFramesIsTooLarge) {
  TrackingStatistics matches = kGood, height = kGood;
  matches.vision_nis = 20;
  height.height_nis = 20;
  EXPECT_EQ(after(14, matches).health(), Health::ok);
  EXPECT_NE(after(15, matches).cause().find("matches are further"), std::string::npos);
  EXPECT_NE(after(15, height).cause().find("the height is further"), std::string::npos);
  matches.vision_nis = 1;
  TrackingMonitor watch = after(100, matches);
  matches.vision_nis = 20;
  watch.judge(matches);
  EXPECT_EQ(watch.health(), Health::ok);  // a single outlier does not count
}

TEST(TrackingMonitor, WithoutRelocalizationALossIsADivergence) {
  Options::Tracking options;
  options.relocalize = false;
  EXPECT_EQ(after(5, kFailed, options).health(), Health::diverged);
}

TEST(TrackingMonitor, RelocalizationEndsTheLossAndGivingUpIsADivergence) {
  TrackingMonitor found = after(5, kFailed), given_up = found;
  found.relocalized();
  EXPECT_EQ(found.health(), Health::ok);
  EXPECT_EQ(found.cause(), "");
  EXPECT_FALSE(found.in_doubt());
  for (int k = 0; k < 20; ++k) given_up.remains_lost(kHalf);
  EXPECT_EQ(given_up.health(), Health::lost);
  given_up.remains_lost(kHalf);
  EXPECT_EQ(given_up.health(), Health::diverged);
  EXPECT_EQ(given_up.cause(), "tracking lost: almost no landmark found; the map was not found again");
}

TEST(TrackingMonitor, TwoSecondsWithoutAnythingSeenAreALossThatEndsWithTheFirstThingSeen) {
  TrackingMonitor watch{Options::Tracking{}};
  for (int k = 0; k < 4; ++k) watch.blind(kHalf, "no image arrives");
  EXPECT_EQ(watch.health(), Health::ok);
  EXPECT_FALSE(watch.is_blind());
  watch.blind(kHalf, "the image is flat");
  EXPECT_EQ(watch.health(), Health::lost);
  EXPECT_TRUE(watch.is_blind());
  EXPECT_EQ(watch.cause(), "tracking lost: the image is flat");
  watch.sees();
  EXPECT_EQ(watch.health(), Health::ok);
  EXPECT_EQ(watch.cause(), "");
  for (int k = 0; k < 4; ++k) watch.blind(kHalf, "no image arrives");
  EXPECT_EQ(watch.health(), Health::ok);  // counted anew
}

TEST(TrackingMonitor, OneThingSeenInTwoSecondsIsEnough) {
  TrackingMonitor watch{Options::Tracking{}};
  for (int k = 0; k < 40; ++k) {
    watch.blind(kHalf, "no image arrives");
    if (k % 3 == 0) watch.sees();
  }
  EXPECT_EQ(watch.health(), Health::ok);
}

TEST(TrackingMonitor, SeeingEndsNoLossThatHasAnotherCause) {
  TrackingMonitor watch = after(5, kFailed);
  EXPECT_FALSE(watch.is_blind());
  watch.sees();
  EXPECT_EQ(watch.health(), Health::lost);
}

TEST(TrackingMonitor, ABlindFilterDivergesAfterTheTimeThatTheOptionsAllow) {
  TrackingMonitor watch{Options::Tracking{}};
  for (int k = 0; k < 5; ++k) watch.blind(kHalf, "no image arrives");
  for (int k = 0; k < 20; ++k) watch.remains_lost(kHalf);
  EXPECT_EQ(watch.health(), Health::lost);
  watch.remains_lost(kHalf);
  EXPECT_EQ(watch.health(), Health::diverged);
  EXPECT_EQ(watch.cause(), "tracking lost: no image arrives; the map was not found again");
}

TEST(TrackingMonitor, ObservationsThatAreAllRefusedAreALossAndInTheEndADivergence) {
  TrackingMonitor watch{Options::Tracking{}};
  for (int k = 0; k < 4; ++k) watch.refuses(kHalf, "its plan is not finite");
  EXPECT_EQ(watch.health(), Health::ok);
  watch.refuses(kHalf, "its plan is not finite");
  EXPECT_EQ(watch.health(), Health::lost);
  EXPECT_TRUE(watch.is_blind());
  EXPECT_EQ(watch.cause(), "tracking lost: observations are refused because its plan is not finite");
  for (int k = 0; k < 20; ++k) watch.refuses(kHalf, "its plan is not finite");
  EXPECT_EQ(watch.health(), Health::lost);
  watch.refuses(kHalf, "its plan is not finite");
  EXPECT_EQ(watch.health(), Health::diverged);
}

TEST(TrackingMonitor, OneObservationThatIsAcceptedEndsTheTimeOfRefusals) {
  TrackingMonitor watch{Options::Tracking{}};
  for (int k = 0; k < 40; ++k) {
    watch.refuses(kHalf, "its time is not after the last one's");
    if (k % 3 == 0) watch.accepts();
  }
  EXPECT_EQ(watch.health(), Health::ok);
}

TEST(TrackingMonitor, KeepsTheFirstCauseOfADivergence) {
  TrackingMonitor watch{Options::Tracking{}};
  watch.diverge("first");
  watch.diverge("second");
  EXPECT_EQ(watch.cause(), "first");
}

}  // namespace
}  // namespace slam
