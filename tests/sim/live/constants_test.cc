// Constants of parts that do not see each other.
#include <gtest/gtest.h>

#include "sim/recording/recording.h"
#include "slam/observation.h"
#include "walking/plan.h"

namespace {

TEST(Constants, PlanAndFilterTakeTheSameGravity) { EXPECT_EQ(walking::kGravity, slam::kGravity); }

TEST(Constants, AReadingOfTheImuLastsATickOfThePlan) {
  EXPECT_EQ(walking::kPeriod, 0.005);
  EXPECT_EQ(slam::kReadingPeriod_s, walking::kPeriod);
  EXPECT_EQ(sim::recording::RecordingSetup{}.imu_rate_hz * walking::kPeriod, 1);
}

}  // namespace
