// External programs give answers, or failures with a clear cause.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>

#include "sim/tracking/tracking.h"

namespace sim::estimators {
namespace {

using testing::HasSubstr;
using testing::StartsWith;
using tracking::Tracked;
using tracking::Tracking;

constexpr int kObservations = 6;

scenario::Scenario scenario_with(const std::string& estimator) {
  constexpr const char* kText = "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n";
  return scenario::read_scenario_text(kText, "test.yaml", {{"estimator=" + estimator}, {}}).scenario;
}

std::string misbehaving(const std::string& behavior, const std::string& message, const std::string& limits) {
  return fmt::format("{{program: [\"{}\", {}, {}]{}}}", GAITSLAM_MISBEHAVING, behavior, message, limits);
}

slam::Observation numbered(int k) {
  slam::Observation o;
  o.t = std::chrono::milliseconds(33 * k);
  o.image = cv::Mat(240, 320, CV_8UC1, cv::Scalar(k));
  o.gyro.push_back({std::chrono::milliseconds(33 * k - 33), o.t, {0.1, 0.2, 0.3}});
  o.plan.emplace();
  return o;
}

Tracked track_program(Tracking tracking) {
  for (int k = 0; k < kObservations; ++k) tracking.step(numbered(k));
  return tracking.finish();
}

/// Tracks a program that misbehaves at the message of this number.
Tracked track_program(const std::string& behavior, const std::string& message = "3",
                      const std::string& limits = "") {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.translation() << 1, 2, 3;
  return track_program(Tracking(scenario_with(misbehaving(behavior, message, limits)), {}, X_WC));
}

TEST(Program, AFailureNamesItsCause) {
  std::ifstream failures(GAITSLAM_SOURCE_DIR "/tests/sim/estimators/failures.txt");
  int count = 0;
  for (std::string line; std::getline(failures, line); ++count) {  // behavior message: cause
    const std::size_t blank = line.find(' '), colon = line.find(": ");
    const std::string behavior = line.substr(0, blank), cause = line.substr(colon + 2),
                      message = line.substr(blank + 1, colon - blank - 1);
    const Tracked tracked = track_program(behavior, message);
    ASSERT_TRUE(tracked.failed) << behavior;
    EXPECT_THAT(*tracked.failed, HasSubstr(cause)) << behavior;
    EXPECT_EQ(tracked.failure()->ending, scenario::Ending::estimator_failed) << behavior;
    EXPECT_EQ(tracked.frames.size(), message[0] == '0' ? 0U : 2U) << behavior;     // earlier ones are kept
    EXPECT_EQ(tracked.untracked.size(), message[0] == '0' ? 6U : 4U) << behavior;  // includes the failed one
  }
  EXPECT_GT(count, 30);
}

TEST(Program, AHangEndsAtItsLimitWithAllChildren) {
  for (const char* behavior : {"hang", "grandchild", "floods_output"}) {
    const Tracked tracked = track_program(behavior, "3", ", answer_within_s: 0.3");
    ASSERT_TRUE(tracked.failed) << behavior;
    const char* cause = "at t = 0.066 s (limit 0.3 s): no answer within its time limit";
    EXPECT_THAT(*tracked.failed, HasSubstr(behavior == std::string("floods_output") ? "" : cause));
  }
  const Tracked tracked = track_program("hang", "0", ", start_within_s: 0.3");
  ASSERT_TRUE(tracked.failed);
  EXPECT_THAT(*tracked.failed, HasSubstr("at its start (limit 0.3 s): no answer within its time limit"));
}

TEST(Program, ALongLogIsTruncatedAndDoesNotBlock) {
  const Tracked tracked = track_program("floods_error");
  EXPECT_FALSE(tracked.failed);
  EXPECT_EQ(tracked.frames.size(), 6U);
  EXPECT_THAT(tracked.log, StartsWith("(the first "));
  EXPECT_THAT(tracked.log, HasSubstr("00029999: a line"));
  EXPECT_LT(tracked.log.size(), 1100000U);
}

TEST(Program, OneThatIsNotReadyOrLostHasNoPose) {
  const Tracked tracked = track_program("openvins");
  EXPECT_FALSE(tracked.failed) << *tracked.failed;
  EXPECT_EQ(tracked.frames.size(), 6U);
  const auto estimates = tracked.estimates();
  ASSERT_EQ(estimates.size(), 2U);
  for (const PoseEstimate& estimate : estimates)
    EXPECT_EQ(estimate.X_WC.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(estimates[0].t, std::chrono::milliseconds(66));
  EXPECT_TRUE(estimates[0].covariance);
  EXPECT_EQ(estimates[1].t, std::chrono::milliseconds(165));
  EXPECT_FALSE(estimates[1].covariance);
  const auto losses = tracked.losses();
  ASSERT_EQ(losses.size(), 2U);
  EXPECT_EQ(losses[0].cause, "the estimator is not ready");
  EXPECT_EQ(losses[1].from, std::chrono::milliseconds(99));
}

TEST(Program, GivingUpIsADivergence) {
  const Tracked tracked = track_program("gives_up");
  EXPECT_FALSE(tracked.failed);
  ASSERT_TRUE(tracked.failure());
  EXPECT_EQ(tracked.failure()->ending, scenario::Ending::diverged);
  EXPECT_EQ(tracked.failure()->cause, "no luck");
  EXPECT_EQ(tracked.frames.size(), 3U);
  EXPECT_EQ(tracked.untracked.size(), 3U);
}

TEST(Program, OneMadeByTheHeaderAnswersAndPrintsToTheLog) {
  const Tracked tracked = track_program("print", "3, header");
  EXPECT_FALSE(tracked.failed) << *tracked.failed;
  const auto estimates = tracked.estimates();
  ASSERT_EQ(estimates.size(), 6U);
  EXPECT_EQ(estimates[5].t, std::chrono::milliseconds(165));
  EXPECT_EQ(estimates[5].X_WC.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(tracked.untracked.empty());
  EXPECT_EQ(tracked.log, "printed by the estimator\n");
  EXPECT_EQ(track_program("print_and_crash", "3, header").log, "printed by the estimator\n");
}

std::vector<rig::RigSensor> preset_rig() {
  const std::vector<rig::Item> items = *rig::preset("d435i_mid360");
  return rig::calibrated(items, {}, 30, 0, std::vector(items.size(), Eigen::Isometry3d::Identity()));
}

TEST(Program, OneOfVersion2IsServedIfThereAreNoFurtherSensors) {
  const Tracked tracked = track_program("version_2", "0");
  EXPECT_FALSE(tracked.failed) << *tracked.failed;
  EXPECT_EQ(tracked.estimates().size(), 6U);
  const scenario::Scenario scenario = scenario_with(misbehaving("version_2", "0", ""));
  EXPECT_THAT([&] { Tracking(scenario, {}, Eigen::Isometry3d::Identity(), 30, preset_rig()); },
              testing::ThrowsMessage<std::invalid_argument>(
                  HasSubstr("speaks version 2 of gaitslam_estimator.h, which knows no sensors but")));
}

TEST(Program, OneMadeByTheHeaderReceivesAllSensorsAlsoThoseOfADroppedFrame) {
  Tracking tracking(
      scenario_with(misbehaving("describes", "2, header", ", time: {model: fixed, frame_ms: 40}")), {},
      Eigen::Isometry3d::Identity(), 30, preset_rig());
  for (int k = 0; k < 4; ++k) {  // the second waits and is replaced by the third
    slam::Observation o = numbered(k);
    if (k == 1) o.t -= std::chrono::milliseconds(32);
    for (int sensor = 0; sensor < 5; ++sensor) o.rig.emplace_back().sensor = sensor, o.rig.back().t = o.t;
    for (int camera : {0, 1, 2})
      o.rig[static_cast<std::size_t>(camera)].image = cv::Mat(2, 3, CV_8UC1, cv::Scalar(10 * k + camera));
    o.rig[3].accelerometer.z() = k;
    o.rig[4].points = {{}, {0, 0, static_cast<float>(k), 0, 0}};
    tracking.step(o);
  }
  const Tracked tracked = tracking.finish();
  EXPECT_FALSE(tracked.failed) << *tracked.failed;
  EXPECT_EQ(tracked.log,
            "cam0 of cam0, 320 px\ncam1 of cam1, 320 px\nrgb0 of rgb0, 424 px\ndepth0 of cam0, 320 px\n"
            "camera 0: 2\ncamera 1: 20\ncamera 2: 21\ncamera 3: 22\nlidar 0: 2\nimu 1: 1\nimu 1: 2\n");
}

TEST(Program, ItsLatestMapIsKept) {
  const Tracked tracked = track_program("maps");
  ASSERT_EQ(tracked.map.size(), 1U);
  EXPECT_EQ(tracked.map[0].id, 42);
  EXPECT_EQ(tracked.map[0].p_W.z(), 1.5);
}

TEST(Program, OneThatCannotBeStartedIsWrongInput) {
  for (const auto& [program, cause] :
       {std::pair("/nowhere/my_slam", "the program /nowhere/my_slam cannot be started"),
        {"no-such-program-anywhere", "cannot be started"},
        {"/tmp", "cannot be started"},
        {"./my_slam --stdio", "words of a list, as in [./my_slam, --stdio]"}}) {
    const scenario::Scenario scenario = scenario_with(fmt::format("{{program: '{}'}}", program));
    EXPECT_THAT([&] { Tracking(scenario, {}, Eigen::Isometry3d::Identity()); },
                testing::ThrowsMessage<std::invalid_argument>(HasSubstr(cause)));
  }
}

TEST(Program, OneThatSleepsIsLateByMeasuredTimeAndMissesFrames) {
  const Tracked tracked = track_program("sleeps", "1", ", time: {model: measured}");
  ASSERT_FALSE(tracked.frames.empty());
  EXPECT_GE(tracked.frames[0].took, std::chrono::milliseconds(50));
  ASSERT_FALSE(tracked.dropped.empty());
  EXPECT_EQ(tracked.dropped[0], numbered(1).t);
}

TEST(Program, ExceptionsOfABuiltInEstimatorAreItsFailure) {
  int steps = 0;
  const auto tracked_with = [](Step step) {
    return track_program(Tracking(scenario_with("plan_alone"), estimator_from(std::move(step))));
  };
  const Tracked thrown = tracked_with([&](const slam::Observation& o) -> Answer {
    if (++steps == 3) throw std::logic_error("no such landmark");
    return {{o.t, Eigen::Isometry3d::Identity(), {}}, {}};
  });
  EXPECT_EQ(thrown.failed, "no such landmark");
  EXPECT_EQ(thrown.frames.size(), 2U);
  EXPECT_EQ(steps, 3);  // no more calls
  const Tracked other = tracked_with([](const slam::Observation&) -> Answer { throw 7; });
  EXPECT_EQ(other.failed, "it threw an exception that is not a std::exception");
  const Tracked nan = tracked_with([](const slam::Observation& o) -> Answer {
    return {{o.t, Eigen::Isometry3d(Eigen::Translation3d(std::nan(""), 0, 0)), {}}, {}};
  });
  EXPECT_EQ(nan.failed, "at t = 0.000 s: its pose is not finite");
}

}  // namespace
}  // namespace sim::estimators
