#include "sim/live/run.h"

#include "tests/sim/live/run_folder.h"

namespace {

namespace fs = std::filesystem;
using sim::result::Outcome;
using sim::scenario::Ending;
using testing::IsEmpty;

// A few steps of the real walk in the real office: long enough for every part of a run. It has motion blur,
// rolling shutter and half a second in the dark; each frame is drawn from three pictures. The rig has a
// sensor of each kind at its own rate, and the filter uses none of them.
constexpr const char* kShortWalk = R"(
walk: {commands: [{stand: {duration_s: 0.5}}, {tangent_arc: {radius_m: 0.75, angle_deg: 10}}]}
camera: {width_px: 160, height_px: 120, exposure_s: 0.01, readout_s: 0.02, subframes: 3}
rig: [{gray: {}}, {color: {width_px: 96, height_px: 64, rate_hz: 7, readout_s: 0.02}}, {depth: {}},
  {depth: {name: depth1, aligned_with: rgb0}}, {imu: {rate_hz: 500}}, {lidar: {points_per_s: 2000}}]
world.lights_off: {from_s: 1, duration_s: 0.5}
slam: {}
limits: {ending: [completed]}
)";

class RunTest : public tests::RunFolder {
 protected:
  using Words = std::vector<std::string>;
  static auto scenario(const Words& overrides = {}, const Words& without = {}) {
    return read(kShortWalk, overrides, without);
  }
  /// The walk without camera and filter.
  static auto blind(Words overrides) {
    overrides.emplace_back("rig=[]");
    return scenario(overrides, {"camera", "slam"});
  }

  /// The folder of the result of scenario(). The tests of a process share it.
  std::string live() const {
    if (!fs::exists(shared_)) {
      EXPECT_EQ(run("live", scenario()).exit_code, 0);
      fs::rename(folder_ / "live", shared_);
    }
    return shared_;
  }
  static void TearDownTestSuite() { fs::remove_all(shared_); }

  static inline const fs::path shared_ =
      fs::temp_directory_path() / ("gaitslam run " + std::to_string(getpid()));
};

TEST_F(RunTest, SameSeedGivesTheSameBitsHoweverImagesAreDrawnAndInAReplayAndARigChangesNoEstimate) {
  ASSERT_EQ(run("two", scenario(), 2).exit_code, 0) << "images drawn beside the walk";
  EXPECT_THAT(tests::differences(live(), folder_ / "two"), IsEmpty());
  ASSERT_EQ(replay(live(), "replay", scenario()).ending, Ending::completed);
  EXPECT_THAT(changed_by_replay(live(), "replay"), IsEmpty());
  ASSERT_EQ(run("alone", scenario({"rig=[]"})).ending, Ending::completed);
  for (const char* name : {"estimate.tum", "truth.tum", "map.csv"})
    EXPECT_EQ(file(live(), name), file("alone", name)) << name;
}

TEST_F(RunTest, ASessionStartsInTheMapOfTheOneBeforeAndEachCanBeReplayed) {
  const auto last = scenario({"rig=[]", "world.start={x_m: 0.2, yaw_deg: 10}", "slam.map.start=known",
                              "world.lights_off={from_s: 0, duration_s: 0}", "limits={ending: [completed]}",
                              "sessions=[{session: {set: [world.start.x_m=0, world.start.yaw_deg=0]}}]"});
  ASSERT_EQ(run("last", last).exit_code, 0);
  const auto robot = [&](const std::string& result) {
    return sim::scenario::read_scenario(folder_ / result / "scenario.yaml").scenario;
  };
  EXPECT_EQ(robot("last/session-1").world.variation.seed, robot("last").seed);
  EXPECT_NE(robot("last/session-1").seed, robot("last").seed);
  EXPECT_EQ(score("last", "first_pose_correct"), 1);
  EXPECT_GT(score("last", "map_reused_fraction"), 0.5);
  EXPECT_TRUE(json("last/session-1", "score.json")["metrics"]["reloc_score"]["value"].is_null());
  ASSERT_EQ(replay("last", "replay", last).ending, Ending::completed);
  Words changed = changed_by_replay("last", "replay");
  std::erase_if(changed, [](const auto& name) { return name.starts_with("session-1/recording/"); });
  EXPECT_THAT(changed, IsEmpty());
  fs::copy(folder_ / "last", folder_ / "moved", fs::copy_options::recursive);
  const auto first = sim::scenario::read_scenario(folder_ / "moved/session-1/scenario.yaml");
  replay("moved/session-1", "alone", first);
  EXPECT_THAT(changed_by_replay("moved/session-1", "alone"), testing::ElementsAre("about.json"))
      << "its keys are set by another file";
}

TEST_F(RunTest, EachSensorOfTheRigIsRecordedAtItsRate) {
  sim::recording::RecordingReader reader(live() + "/recording");
  const double end_s = slam::seconds(sim::recording::read_truth(live() + "/recording").camera.back().t);
  std::vector<int> readings(6);
  slam::Stamp last_imu{0};
  while (const auto observation = reader.next())
    for (const slam::RigReading& reading : observation->rig) {
      ++readings.at(std::size_t(reading.sensor));
      EXPECT_LE(reading.t, observation->t + std::chrono::milliseconds(15)) << "the shutter has closed";
      if (reading.sensor != 4) continue;
      EXPECT_EQ(reading.begin, last_imu) << "readings adjoin";
      last_imu = reading.t;
    }
  const std::vector<double> rates{30, 7, 30, 7, 500, 10};
  for (std::size_t i = 0; i < rates.size(); ++i) EXPECT_NEAR(readings[i], rates[i] * end_s, 2) << i;
}

TEST_F(RunTest, LeavesEveryFileOfACompleteResult) {
  for (const char* name :
       {"scenario.yaml", "about.json", "truth.tum", "plan.tum", "estimate.tum", "estimate_smoothed.tum",
        "waist_truth.tum", "waist_plan.tum", "estimate_cov.txt", "map.csv", "landmarks.csv", "frames.csv",
        "searches.csv", "timing.csv", "timing.json", "score.json", "recording/manifest.csv",
        "recording/mav0/cam0/data.csv"})
    EXPECT_TRUE(fs::exists(live() + "/" + name)) << name;
  for (const char* key : {"frame_cpu_ms_mean", "frame_cpu_ms_median", "frame_cpu_ms_p99", "realtime_factor"})
    EXPECT_GT(json(live(), "timing.json")[key].get<double>(), 0) << key;
  EXPECT_EQ(json(live(), "score.json")["metrics"]["loop_closed"]["reason"],
            "the camera never returned to a landmark after it had been elsewhere");
}

TEST_F(RunTest, PassesTheSelfCheck) {
  const nlohmann::json check = json(live(), "recording/self_check.json");
  EXPECT_EQ(check["complaint"], "");
  EXPECT_GT(check["inertial_position_m"]["worst"], 0);  // not the inverse of the sensor's formula
}

TEST_F(RunTest, ARunThatFailsTheSelfCheckIsNotScored) {
  const fs::path recording = live() + "/recording";
  const std::string cause = "self-check: it is off";
  const sim::result::RunRecord record{scenario(),
                                      {Ending::failed, cause},
                                      sim::recording::RecordingReader(recording).setup(),
                                      sim::recording::read_truth(recording),
                                      std::nullopt,
                                      "hash"};
  fs::create_directories(folder_ / "failed");
  EXPECT_EQ(sim::result::write_result(folder_ / "failed", record, {}, sim::result::Timing(), 1).exit_code, 3);
  EXPECT_EQ(json("failed", "score.json")["ending"], "failed");
  for (const auto& [name, metric] : json("failed", "score.json")["metrics"].items()) {
    EXPECT_TRUE(metric["value"].is_null()) << name;
    EXPECT_EQ(metric["reason"], "not scored: " + cause);
  }
  EXPECT_EQ(json("failed", "about.json")["cause"], cause);
  EXPECT_TRUE(fs::exists(folder_ / "failed/truth.tum"));
}

TEST_F(RunTest, AWalkEndedByAViolentPushCountsAsFellNotFailed) {
  for (const char* impulse_ns : {"500", "10000"}) {
    run(impulse_ns, blind({std::string("world.pushes=[{push: {time_s: 1, duration_s: 0.1, impulse_ns: ") +
                           impulse_ns + "}}]"}));
    EXPECT_EQ(json(impulse_ns, "about.json")["ending"], "fell") << json(impulse_ns, "about.json")["cause"];
    EXPECT_EQ(json(impulse_ns, "recording/self_check.json")["complaint"], "") << impulse_ns;
  }
}

TEST_F(RunTest, TheWalkDependsOnSeedAndArmsButNotOnCameraAndFilter) {
  EXPECT_EQ(run("blind", blind({"limits.path_length_m.at_least=1000"})).exit_code, 1) << "a missed limit";
  EXPECT_EQ(file(live(), "truth.tum"), file("blind", "truth.tum"));
  EXPECT_FALSE(fs::exists(folder_ / "blind/estimate.tum"));
  EXPECT_TRUE(json("blind", "score.json")["metrics"]["ate_se3_rmse_m"]["value"].is_null());
  for (const char* change : {"walk.arm_motion=swing", "seed=2"}) {
    run(change, blind({change}));
    EXPECT_NE(file(change, "truth.tum"), file("blind", "truth.tum"));
    EXPECT_EQ(file(change, "plan.tum"), file("blind", "plan.tum"));
  }
}

TEST_F(RunTest, AFallEndsTheRunWithACompleteFolderAndExitCodeThree) {
  const Outcome outcome = run("fall", blind({"stabilizer.enabled=false", "world.floor_friction=0.05"}));
  EXPECT_EQ(outcome.ending, Ending::fell) << outcome.cause;
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(json("fall", "score.json")["ending"], "fell");
  EXPECT_TRUE(fs::exists(folder_ / "fall/recording/manifest.csv"));
}

// A robot that is put on the floor sinks into its pads and bushings, shaking at up to 10 m/s². That is over
// before t = 0. A standing robot sways by less than 0.05 m/s².
TEST_F(RunTest, TheRecordingStartsAtRest) {
  for (const char* seed : {"seed=1", "seed=2", "seed=3"}) {
    run(seed, blind({seed, "walk.commands=[{stand: {duration_s: 0.5}}]"}));
    sim::recording::RecordingReader reader(folder_ / seed / "recording");
    int readings = 0;
    for (auto o = reader.next(); o && o->t < std::chrono::milliseconds(500); o = reader.next())
      for (std::size_t i = 0; i < o->gyro.size(); ++i, ++readings) {
        EXPECT_NEAR(o->accelerometer[i].value.norm(), walking::kGravity, 0.3) << seed << " " << i;
        EXPECT_LT(o->gyro[i].value.norm(), 0.03) << seed << " " << i;
      }
    EXPECT_GT(readings, 90) << seed;
    const sim::recording::Truth truth = sim::recording::read_truth(folder_ / seed / "recording");
    EXPECT_EQ(truth.waist.front().t.count(), 0);
    EXPECT_NEAR(truth.waist.front().X.translation().z(), 0.6487, 0.005);
    EXPECT_LT(truth.waist.front().X.translation().head<2>().norm(), 0.01);
  }
}

TEST_F(RunTest, ARunThatCannotStartLeavesNothingBehind) {
  EXPECT_ANY_THROW(run("no", scenario({"world.room=cellar"})));
  EXPECT_ANY_THROW(run("no", scenario({"world.robot=nobody"})));
  EXPECT_ANY_THROW(run("no", scenario({"world.room=floor", "world.moved.seed=1"}))) << "no furniture to move";
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST(Constants, OfIndependentPartsAgree) {
  EXPECT_EQ(walking::kGravity, slam::kGravity);
  EXPECT_EQ(walking::kPeriod, 0.005);
  EXPECT_EQ(slam::kReadingPeriod_s, walking::kPeriod) << "a reading of the IMU lasts a tick of the plan";
  EXPECT_EQ(sim::recording::RecordingSetup{}.imu_rate_hz * walking::kPeriod, 1);
}

}  // namespace
