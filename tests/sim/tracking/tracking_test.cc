#include "sim/tracking/tracking.h"

#include "tests/sim/scenario/test_scenarios.h"

namespace sim::tracking {
namespace {

scenario::Scenario scenario(const std::vector<std::string>& overrides) {
  return scenario::read_text(scenario::kAll, {overrides, {}}).scenario;
}

slam::Observation observation(int millisecond, double x_m) {
  slam::Observation o;
  o.t = std::chrono::milliseconds(millisecond);
  o.plan.emplace();
  o.plan->X_PC.translation().x() = x_m;
  return o;
}

Tracked track(const std::string& estimator, const std::vector<slam::Observation>& observations) {
  Tracking tracking(scenario({"estimator=" + estimator}), {}, Eigen::Isometry3d::Identity());
  for (const slam::Observation& o : observations) tracking.process(o);
  return tracking.finish();
}

TEST(Tracking, EstimatorsThatNeedAPlanAreLostBeforeTheFirstOne) {
  slam::Observation first = observation(0, 0);
  first.plan.reset();
  for (const char* const estimator : {"plan_alone", "{program: [/usr/bin/python3, '" GAITSLAM_SOURCE_DIR
                                                    "/tools/examples/gyro_and_plan.py']}"}) {
    const Tracked tracked = track(estimator, {first, observation(33, 0.5)});
    EXPECT_EQ(tracked.estimates().size(), 1U) << estimator;
    EXPECT_EQ(tracked.losses().size(), 1U) << estimator;
  }
}

TEST(Tracking, ImageFreeOdometryRunsBesideEveryOtherEstimator) {
  const std::vector<slam::Observation> walk{observation(0, 0), observation(33, 0.01), observation(67, 0.02)};
  const Tracked alone = track("odometry", walk);
  EXPECT_TRUE(alone.odometry.empty());
  for (const char* const estimator : {"filter", "plan_alone"}) {
    const Tracked tracked = track(estimator, walk);
    ASSERT_EQ(tracked.odometry.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(tracked.odometry[i].X_WC.matrix(), alone.estimates()[i].X_WC.matrix());
  }
}

/// The result of the filter on an image of random blocks.
Tracked first_image(const std::vector<std::string>& overrides) {
  slam::Observation o;
  o.image.create(240, 320, CV_8UC1);
  std::uint32_t random = 1;
  for (int row = 0; row < 240; row += 8)
    for (int column = 0; column < 320; column += 8) {
      random = 1664525 * random + 1013904223;
      o.image(cv::Rect(column, row, 8, 8)).setTo(random >> 24);
    }
  slam::Calibration calibration;
  Tracking tracking(scenario(overrides), calibration, Eigen::Isometry3d::Identity());
  tracking.process(o);
  return tracking.finish();
}
std::vector<slam::MapPoint> first_landmarks(const std::string& override) {
  return first_image({override}).map;
}

TEST(Tracking, AWrongLensShiftsTheLandmarks) {
  const auto right = first_landmarks("errors.calibration.distortion_fraction=0"),
             wrong = first_landmarks("errors.calibration.distortion_fraction=0.2");
  ASSERT_FALSE(right.empty());
  ASSERT_EQ(right.size(), wrong.size());
  double widest = 0;
  for (std::size_t i = 0; i < right.size(); ++i)
    widest = std::max(widest, (right[i].p_W.normalized() - wrong[i].p_W.normalized()).norm());
  EXPECT_GT(widest, 0.01);  // rad
}

TEST(Tracking, AStartInTheRoomIsTheFrameOfTheSavedMapAndAnswersAreInW) {
  const Tracked here = first_image({}),
                there = first_image({"world.start={x_m: 2, y_m: -1, yaw_deg: 90}", "slam.map.save=true"});
  ASSERT_TRUE(!here.saved_map && there.saved_map && !here.map.empty());
  ASSERT_EQ(here.map.size(), there.map.size());
  for (std::size_t i = 0; i < here.map.size(); ++i) {
    EXPECT_TRUE(here.map[i].p_W.isApprox(there.map[i].p_W, 1e-9));
    EXPECT_TRUE(here.map[i].covariance.isApprox(there.map[i].covariance, 1e-6));
  }
  const slam::SavedMap& map = *there.saved_map;
  EXPECT_TRUE(map.landmarks[0].X_WC_first.translation().isApprox(Eigen::Vector3d(2, -1, 0)));
  EXPECT_TRUE(there.estimates()[0].X_WC.isApprox(here.estimates()[0].X_WC, 1e-9));
  EXPECT_TRUE(there.estimates()[0].covariance->isApprox(*here.estimates()[0].covariance, 1e-6));
  const auto other = track("plan_alone", {observation(0, 0.3)}).estimates()[0].X_WC;
  Tracking plan(scenario({"estimator=plan_alone", "world.start.x_m=5"}), {}, Eigen::Isometry3d::Identity());
  plan.process(observation(0, 0.3));
  EXPECT_TRUE(plan.answers()[0].estimate->X_WC.isApprox(other, 1e-9));
}

TEST(Tracking, AMapThatIsMissingIsAnErrorBeforeTheFirstObservation) {
  EXPECT_THROW(first_image({"slam.map.load=nowhere/map.bin"}), files::FileError);
}

TEST(Tracking, AScenarioCanNameEveryBuiltInEstimatorAndNoOthers) {
  for (const std::string_view name : estimators::estimator_names())
    EXPECT_EQ(scenario({"estimator=" + std::string(name)}).estimator.name, name);
  EXPECT_ANY_THROW(scenario({"estimator=plan_alnoe"}));
}

/// Returns "stamp:effect" of each answer and "-stamp" of each dropped frame, in ms.
std::string answers(const std::string& time) {
  Tracking tracking(scenario({"estimator=plan_alone", "estimator.time=" + time}), {},
                    Eigen::Isometry3d::Identity());
  for (const int t : {0, 33, 67, 100, 133}) tracking.process(observation(t, 0));
  const Tracked tracked = tracking.finish();
  const auto ms = [](slam::Stamp t) { return std::to_string(t / std::chrono::milliseconds(1)); };
  std::string text;
  for (const TrackedFrame& frame : tracked.frames) text += ms(frame.report.t) + ":" + ms(frame.effect) + " ";
  for (const slam::Stamp t : tracked.dropped) text += "-" + ms(t) + " ";
  return text;
}

TEST(EstimatorTime, FramesAreAnsweredWhenTheEstimatorIsFreeOrDropped) {
  const std::string at_once = "0:0 33:33 67:67 100:100 133:133 ";
  for (const auto& [time, expected] : std::vector<std::pair<std::string, std::string>>{
           {"{model: none}", at_once},
           {"{model: fixed, frame_ms: 0}", at_once},
           {"{model: fixed, frame_ms: 33}", "0:33 33:66 67:100 100:133 133:166 "},
           {"{model: fixed, frame_ms: 60}", "0:60 67:127 133:193 -33 -100 "},
           {"{model: fixed, frame_ms: 60, queue: 1}", "0:60 33:120 100:180 133:240 -67 "},
           {"{model: fixed, frame_ms: 60, on_busy: wait}", "0:60 33:120 67:180 100:240 133:300 "},
           {"{model: fixed, frame_ms: 1000}", "0:1000 -33 -67 -100 -133 "},
           {"{model: fixed, frame_ms: 1000, queue: 1}", "0:1000 133:2000 -33 -67 -100 "}})
    EXPECT_EQ(answers(time), expected) << time;
}

// The rig has an IMU whose clock is ahead by more than a frame, and a lidar with dropped sweeps.
TEST(EstimatorTime, ReadingsOfDroppedFramesComeOnceWithTheNextFrameButSweepsDoNot) {
  using std::chrono::milliseconds;
  std::vector<rig::RigSensor> rig(2);
  rig[0].name = "imu1", rig[0].kind = rig::Kind::imu, rig[0].time_offset_s = 0.05;
  rig[0].rate_hz = 1000. / 11;
  rig[1].name = "lidar0", rig[1].kind = rig::Kind::lidar, rig[1].furthest_m = 40;
  for (const auto& [more, fault] :
       {std::pair("", ""), {"", "{frames_doubled: {from_s: 0, duration_s: 0.5}}"}, {", queue: 1", ""}}) {
    SCOPED_TRACE(std::string(more) + fault);
    slam::Stamp end{0}, body{0}, imu = milliseconds(50);
    const auto check = [&](const slam::Observation& o) {
      for (const slam::InertialSample& reading : o.gyro)
        EXPECT_EQ(reading.begin, std::exchange(end, reading.end));
      for (const slam::BodyReading& reading : o.body)
        EXPECT_EQ(reading.t, std::exchange(body, body + milliseconds(11)));
      int sweeps = 0;
      for (const slam::RigReading& reading : o.rig) {
        const bool sweep = reading.sensor == 1;
        sweeps += sweep;
        EXPECT_EQ(sweep ? reading.t : reading.begin, sweep ? o.t : std::exchange(imu, reading.t));
      }
      EXPECT_TRUE(end == o.t && body == o.t && imu == o.t + milliseconds(50));
      EXPECT_EQ(sweeps, 1);
      return estimators::Answer{estimators::PoseEstimate{o.t, Eigen::Isometry3d::Identity(), {}}, {}};
    };
    Tracking tracking(scenario({std::string("estimator.time={model: fixed, frame_ms: 60") + more + "}",
                                std::string("errors.faults=[") + fault + "]"}),
                      estimators::estimator_from(check), rig);
    for (int k = 1; k <= 9; ++k) {
      slam::Observation o = observation(33 * k, 0);
      for (int t = 33 * k - 33; t < 33 * k; t += 11) {
        o.gyro.push_back({milliseconds(t), milliseconds(t + 11), {}});
        o.body.emplace_back().t = milliseconds(t);
        o.rig.emplace_back().t = milliseconds(t + 11);
        o.rig.back().begin = milliseconds(t);
      }
      o.rig.emplace_back().sensor = 1;
      o.rig.back().t = o.t;
      tracking.process(o);
    }
    EXPECT_FALSE(tracking.finish().dropped.empty());
  }
}

TEST(Tracking, ARejectedObservationGivesNoNewEstimate) {
  const Tracked tracked =
      track("filter", {observation(0, 0), observation(33, 0), observation(33, 0), observation(20, 0)});
  EXPECT_EQ(tracked.frames.size(), 4U);
  EXPECT_TRUE(tracked.frames[3].report.refused);
  EXPECT_EQ(tracked.estimates().size(), 2U);
}

TEST(Tracking, LossesAndSuspicionsAreReportedWithTimesAndLastCauses) {
  Tracked tracked;
  for (int k = 0; k < 6; ++k) {
    slam::FrameReport& report = tracked.frames.emplace_back().report;
    report.t = std::chrono::seconds(k);
    if (k == 1 || k == 2 || k == 5) report.suspect = "plan, " + std::to_string(k);
  }
  EXPECT_FALSE(tracked.failure());  // it still tracks
  for (const std::size_t k : {1u, 2u, 5u})
    tracked.frames[k].report.health = slam::Health::lost,
    tracked.frames[k].report.cause = "dark, " + std::to_string(k);
  for (const auto& [faults, cause] :
       {std::pair(tracked.losses(), std::string("dark, ")), {tracked.suspicions(), "plan, "}}) {
    ASSERT_EQ(faults.size(), 2U);
    EXPECT_EQ(faults[0].from, std::chrono::seconds(1));
    EXPECT_EQ(faults[0].to, std::optional<slam::Stamp>(std::chrono::seconds(3)));
    EXPECT_EQ(faults[0].cause, cause + "2");
    EXPECT_EQ(faults[1].cause, cause + "5");
    EXPECT_FALSE(faults[1].to);
  }
  ASSERT_TRUE(tracked.failure());  // it is lost at the end
  EXPECT_EQ(tracked.failure()->ending, scenario::Ending::diverged);
  EXPECT_EQ(tracked.failure()->cause, "dark, 5; the map was not found again before the end");
}

}  // namespace
}  // namespace sim::tracking
