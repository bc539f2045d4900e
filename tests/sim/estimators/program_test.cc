// Tests that external programs give answers, or failures with a clear cause.
#include "sim/tracking/tracking.h"
#include "tests/sim/scenario/test_scenarios.h"

namespace sim::estimators {
namespace {

using testing::HasSubstr, testing::StartsWith, tracking::Tracked, tracking::Tracking;

constexpr int kObservations = 6;

scenario::Scenario scenario_with(const std::string& estimator) {
  return scenario::read_text(scenario::kAll, {{"estimator=" + estimator}, {}}).scenario;
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

// Only a missed time limit is reported as one.
TEST(Program, AFailureNamesTheEstimatorAndItsCause) {
  for (const auto& row : tests::rows_of("sim/estimators/failures.txt")) {
    const std::string &behavior = row.at(0), &more = row.at(2);
    const bool has_limit = more.find("within") != more.npos;
    const std::size_t answers = std::stoul(row.at(3));
    const Tracked tracked = track_program(behavior, row.at(1) + (more == "header" ? ", header" : ""),
                                          has_limit ? ", " + more : "");
    ASSERT_TRUE(tracked.failed) << behavior << row[1];
    EXPECT_THAT(*tracked.failed, StartsWith("the estimator misbehaving_program failed at "));
    EXPECT_THAT(*tracked.failed, HasSubstr(row.at(4))) << behavior;
    EXPECT_EQ(tracked.failed->find("no input"), std::string::npos) << "written at the end of its input";
    EXPECT_EQ(tracked.failed->find("within") != std::string::npos, has_limit);
    EXPECT_EQ(tracked.failure()->ending, scenario::Ending::estimator_failed) << behavior;
    EXPECT_EQ(tracked.frames.size(), answers) << behavior << row[1];
    EXPECT_EQ(tracked.untracked.size(), kObservations - answers) << behavior;  // includes the failed one
  }
}

// An extra answer that arrives after the next observation was sent looks like an answer without a new pose.
TEST(Program, AnExtraAnswerNeverPassesHoweverLateItIs) {
  for (const char* message : {"3", "6"})
    EXPECT_THAT(track_program("twice_later", message).failed.value_or(""),
                HasSubstr("it wrote more than one message"));
}

TEST(Program, AProgramThatCannotStartOrRejectsItsStartIsAnInputError) {
  const auto rejection = [](const std::string& estimator) {
    const scenario::Scenario scenario = scenario_with(estimator);
    return files::error_of<std::invalid_argument>(
        [&] { Tracking(scenario, {}, Eigen::Isometry3d::Identity(), 30); });
  };
  for (const auto& [program, cause] :
       {std::pair("/nowhere/my_slam", "the program /nowhere/my_slam cannot be started"),
        {"no-such-program-anywhere", "cannot be started"},
        {"/tmp", "cannot be started"},
        {"./my_slam --stdio", "words of a list, as in [./my_slam, --stdio]"}})
    EXPECT_THAT(rejection(fmt::format("{{program: '{}'}}", program)), HasSubstr(cause));
  const files::TemporaryFolder folder;
  for (const auto& [first_line, cause] :
       {std::pair("#!/usr/bin/python3\r\n",
                  "the interpreter '/usr/bin/python3\\r', which does not exist: the "
                  "lines end with CR LF, expected LF"),
        {"#! /usr/bin/python9 -u\n", "the interpreter '/usr/bin/python9', which does not exist"}}) {
    const fs::path script = folder / "script.py";
    files::write_text(script, first_line);
    fs::permissions(script, fs::perms::owner_all);
    EXPECT_THAT(rejection(fmt::format("{{program: '{}'}}", script.string())), HasSubstr(cause));
    EXPECT_THAT(files::error_of<std::invalid_argument>(
                    [&] { programs::require_program({.words = {script.string()}}, "controller"); }),
                HasSubstr(cause));
  }
  for (const auto& [behavior, cause] :
       {std::pair("cannot_start", "it cannot start: no vocabulary"),
        {"wrong_version", "it speaks version 99 of gaitslam_estimator.h, expected 4"},
        {"wrong_type", "its message is of type 77, expected 2"},
        {"prints", "its standard output is not a message: it starts with 'Loading"}})
    EXPECT_THAT(rejection(misbehaving(behavior, "0", "")),
                HasSubstr(std::string("estimator: misbehaving_program: ") + cause));
}

TEST(Program, AnAnswerWithTheStampOfALateObservationIsAcceptedAndAddsNoPose) {
  Tracking tracking(scenario_with(misbehaving("none", "0", "")), {}, Eigen::Isometry3d::Identity());
  for (const int k : {0, 2, 1, 3, 3}) tracking.step(numbered(k));
  const Tracked tracked = tracking.finish();
  EXPECT_FALSE(tracked.failed) << *tracked.failed;
  ASSERT_EQ(tracked.frames.size(), 5U);
  EXPECT_FALSE(tracked.frames[2].estimate);
  EXPECT_EQ(tracked.estimates().size(), 3U);
}

TEST(Program, ALongLogIsTruncatedAndDoesNotBlock) {
  const Tracked tracked = track_program("floods_error");
  EXPECT_FALSE(tracked.failed);
  EXPECT_EQ(tracked.frames.size(), 6U);
  EXPECT_THAT(tracked.log, StartsWith("(the first "));
  EXPECT_THAT(tracked.log, HasSubstr("00029999: a line"));
  EXPECT_LT(tracked.log.size(), 1100000U);
}

TEST(Program, HasNoPoseWhileNotReadyOrLost) {
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

TEST(Program, GivingUpCountsAsDivergence) {
  const Tracked tracked = track_program("gives_up");
  EXPECT_FALSE(tracked.failed);
  ASSERT_TRUE(tracked.failure());
  EXPECT_EQ(tracked.failure()->ending, scenario::Ending::diverged);
  EXPECT_EQ(tracked.failure()->cause, "no luck");
  EXPECT_EQ(tracked.frames.size(), 3U);
  EXPECT_EQ(tracked.untracked.size(), 3U);
}

TEST(Program, AProgramBuiltOnTheHeaderAnswersAndPrintsToTheLog) {
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

TEST(Program, AProgramBuiltOnTheHeaderReceivesAllReadingsEvenThoseOfADroppedFrame) {
  Tracking tracking(
      scenario_with(misbehaving("describes", "2, header", ", time: {model: fixed, frame_ms: 40}")), {},
      Eigen::Isometry3d::Identity(), 30, preset_rig());
  for (int k = 0; k < 4; ++k) {  // the second waits and is replaced by the third
    slam::Observation o = numbered(k);
    if (k == 1) o.t -= std::chrono::milliseconds(32);
    for (int sensor = 0; sensor < 5; ++sensor) o.rig.emplace_back().sensor = sensor, o.rig.back().t = o.t;
    for (std::size_t camera = 0; const int type : {CV_8UC1, CV_8UC3, CV_16UC1})
      o.rig[camera++].image = cv::Mat(2, 3, type, cv::Scalar(10 * k + int(camera)));
    o.rig[3].accelerometer.z() = k, o.rig[3].gyro.y() = 0.5;
    o.rig[4].points = {{}, {0, 0, float(k), 0.25F, 80}};
    tracking.step(o);
  }
  const Tracked tracked = tracking.finish();
  EXPECT_FALSE(tracked.failed) << *tracked.failed;
  EXPECT_EQ(tracked.log,
            "cam0 of cam0, 320 px\ncam1 of cam1, 320 px\nrgb0 of rgb0, 424 px\ndepth0 of cam0, 320 px\n"
            "camera 0: 320 px of kind 0, 320 bytes a row, at 66000000 ns: 2\n"
            "camera 1: 3 px of kind 0, 3 bytes a row, at 66000000 ns: 20\n"
            "camera 2: 3 px of kind 1, 9 bytes a row, at 66000000 ns: 21\n"
            "camera 3: 3 px of kind 2, 6 bytes a row, at 66000000 ns: 22\n"
            "lidar 0: 2, 0.25, 80 ns\nimu 1: 0.5 1\nimu 1: 0.5 2\n");
}

TEST(Program, KeepsTheLatestMap) {
  const Tracked tracked = track_program("maps");
  ASSERT_EQ(tracked.map.size(), 1U);
  EXPECT_EQ(tracked.map[0].id, 42);
  EXPECT_EQ(tracked.map[0].p_W.z(), 1.5);
}

TEST(Program, AProgramThatSleepsIsLateByTheMeasuredTimeAndMissesFrames) {
  const Tracked tracked = track_program("sleeps", "1", ", time: {model: measured}");
  ASSERT_FALSE(tracked.frames.empty());
  EXPECT_GE(tracked.frames[0].took, std::chrono::milliseconds(50));
  ASSERT_FALSE(tracked.dropped.empty());
  EXPECT_EQ(tracked.dropped[0], numbered(1).t);
}

TEST(Program, ExceptionsOfABuiltInEstimatorCountAsItsFailure) {
  int steps = 0;
  const auto tracked_with = [](Step step) {
    return track_program(Tracking(scenario_with("plan_alone"), estimator_from(std::move(step))));
  };
  const Tracked thrown = tracked_with([&](const slam::Observation& o) -> Answer {
    if (++steps == 3) throw std::logic_error("no such landmark");
    return {PoseEstimate{o.t, Eigen::Isometry3d::Identity(), {}}, {}};
  });
  EXPECT_EQ(thrown.failed, "no such landmark");
  EXPECT_EQ(thrown.frames.size(), 2U);
  EXPECT_EQ(steps, 3);  // no more calls
  const Tracked other = tracked_with([](const slam::Observation&) -> Answer { throw 7; });
  EXPECT_EQ(other.failed, "it threw an exception that is not a std::exception");
  const Tracked nan = tracked_with([](const slam::Observation& o) -> Answer {
    return {PoseEstimate{o.t, Eigen::Isometry3d(Eigen::Translation3d(std::nan(""), 0, 0)), {}}, {}};
  });
  EXPECT_EQ(nan.failed, "at t = 0.000 s: its pose is not finite");
}

}  // namespace
}  // namespace sim::estimators
