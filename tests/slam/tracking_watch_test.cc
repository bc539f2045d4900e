#include "slam/tracking_watch.h"

#include <gtest/gtest.h>

namespace slam {
namespace {

const TrackingStatistics kFailed{0.5, 12, 1, 1, {}, {}}, kGood{0.5, 12, 10, 1, {}, {}};

/// A watch after `frames` frames of the given statistics.
TrackingWatch after(int frames, const TrackingStatistics& statistics, const Options::Tracking& options = {}) {
  TrackingWatch watch(options);
  for (int k = 0; k < frames; ++k) watch.judge(statistics);
  return watch;
}

TEST(TrackingWatch, TrackingIsLostAfterTwoSecondsOfFailedMatching) {
  TrackingWatch watch = after(4, kFailed);
  EXPECT_EQ(watch.health(), Health::ok);
  EXPECT_TRUE(watch.in_doubt());
  watch.judge(kFailed);
  EXPECT_EQ(watch.health(), Health::lost);
  EXPECT_EQ(watch.cause(), "tracking lost: almost no landmark found");
}

TEST(TrackingWatch, OneGoodFrameEndsTheDoubt) {
  TrackingWatch watch = after(4, kFailed);
  watch.judge(kGood);
  EXPECT_FALSE(watch.in_doubt());
  watch.judge(kFailed);
  EXPECT_EQ(watch.health(), Health::ok);
}

TEST(TrackingWatch, AnOccludedPartOfTheImageIsNoFailure) {
  TrackingStatistics occluded = kFailed;
  occluded.coverage = 0.3;
  EXPECT_FALSE(matching_failed(occluded));
  EXPECT_TRUE(matching_failed(kFailed));
  EXPECT_EQ(after(20, occluded).health(), Health::ok);
}

TEST(TrackingWatch, TrackingIsLostWhenTheMeanInnovationOfFifteenFramesIsTooLarge) {
  TrackingStatistics matches = kGood, height = kGood;
  matches.vision_nis = 20;
  height.height_nis = 20;
  EXPECT_EQ(after(14, matches).health(), Health::ok);
  EXPECT_NE(after(15, matches).cause().find("matches are further"), std::string::npos);
  EXPECT_NE(after(15, height).cause().find("the height is further"), std::string::npos);
  matches.vision_nis = 1;
  TrackingWatch watch = after(100, matches);
  matches.vision_nis = 20;
  watch.judge(matches);
  EXPECT_EQ(watch.health(), Health::ok);  // a single outlier does not count
}

TEST(TrackingWatch, WithoutRelocalisationALossIsADivergence) {
  Options::Tracking options;
  options.relocalise = false;
  EXPECT_EQ(after(5, kFailed, options).health(), Health::diverged);
}

TEST(TrackingWatch, RelocalisationEndsTheLossAndGivingUpIsADivergence) {
  TrackingWatch found = after(5, kFailed), given_up = found;
  found.relocalised();
  EXPECT_EQ(found.health(), Health::ok);
  EXPECT_EQ(found.cause(), "");
  EXPECT_FALSE(found.in_doubt());
  for (int k = 0; k < 20; ++k) given_up.relocalisation_failed(0.5);
  EXPECT_EQ(given_up.health(), Health::lost);
  given_up.relocalisation_failed(0.5);
  EXPECT_EQ(given_up.health(), Health::diverged);
  EXPECT_EQ(given_up.cause(), "tracking lost: almost no landmark found, and the map was not found again");
}

TEST(TrackingWatch, KeepsTheFirstCauseOfADivergence) {
  TrackingWatch watch{Options::Tracking{}};
  watch.diverge("first");
  watch.diverge("second");
  EXPECT_EQ(watch.cause(), "first");
}

}  // namespace
}  // namespace slam
