// Whatever a library does, it is an answer or a failure of the estimator with a clear cause.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "sim/estimators/library_estimator.h"
#include "sim/tracking/tracking.h"

namespace sim::estimators {
namespace {

using testing::HasSubstr;
using tracking::Tracked;
using tracking::Tracking;

Tracked track_library(const std::string& behaviour, const std::string& limits = "") {
  constexpr const char* kText = "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n";
  const std::string estimator = fmt::format("estimator={{library: \"{}\", options: {{behaviour: {}}}{}}}",
                                            GAITSLAM_MISBEHAVING_LIBRARY, behaviour, limits);
  Tracking tracking(scenario::read_scenario_text(kText, "test.yaml", {{estimator}, {}}).scenario, {},
                    Eigen::Isometry3d::Identity());
  for (int k = 0; k < 6; ++k) {
    slam::Observation o;
    o.t = std::chrono::milliseconds(33 * k);
    tracking.step(o);
  }
  return tracking.finish();
}

TEST(Library, WhatItDoesWrongIsItsFailureAndNotTheBenchs) {
  for (const auto& [behaviour, cause] :
       {std::pair<std::string, std::string>{"crash", "it was killed by signal 11"},
        {"exit", "it ended with exit code 0"},
        {"say_why", "its last lines: the map is broken"},
        {"huge", "it announces 3000000000 landmarks, expected at most 100000"},
        {"nowhere", "it announces 3 landmarks, expected at most 100000, and where they are"}}) {
    const Tracked tracked = track_library(behaviour);
    ASSERT_TRUE(tracked.failed) << behaviour;
    EXPECT_THAT(*tracked.failed, HasSubstr("libmisbehaving_library.so failed at t = 0.066 s (limit 10 s)"));
    EXPECT_THAT(*tracked.failed, HasSubstr(cause)) << behaviour;
    EXPECT_EQ(tracked.frames.size(), 2U) << behaviour;  // those before are kept
  }
  const Tracked tracked = track_library("crash_at_start");
  ASSERT_TRUE(tracked.failed);
  EXPECT_THAT(*tracked.failed, HasSubstr("failed at its start (limit 60 s): it was killed by signal 6"));
}

TEST(Library, AHangEndsAtItsLimit) {
  const Tracked tracked = track_library("hang", ", answer_within_s: 0.3");
  ASSERT_TRUE(tracked.failed);
  EXPECT_THAT(*tracked.failed, HasSubstr("(limit 0.3 s): no answer within its time limit"));
}

TEST(Library, WhatItPrintsIsInTheLogAndDisturbsNoMessage) {
  const Tracked tracked = track_library("print");
  EXPECT_FALSE(tracked.failed) << *tracked.failed;
  EXPECT_EQ(tracked.frames.size(), 6U);
  EXPECT_EQ(tracked.log, "what a library prints\n");
}

TEST(Library, AFileThatIsNoneIsWrongInput) {
  EstimatorChoice choice;
  choice.source = Source::library;
  choice.words = {"/etc/passwd"};
  try {
    library_estimator(choice, {});
    FAIL();
  } catch (const std::invalid_argument& refused) {
    EXPECT_THAT(refused.what(), HasSubstr("estimator: cannot be loaded: /etc/passwd: "));
  }
}

}  // namespace
}  // namespace sim::estimators
