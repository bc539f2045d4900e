#include "sim/live/run.h"

#include "tests/sim/live/run_folder.h"

namespace {

namespace fs = std::filesystem;
using sim::result::Outcome;
using sim::scenario::Ending;
using testing::IsEmpty;

// A few steps of the real walk in the real office: long enough for every part of a run. It has motion blur,
// rolling shutter and half a second in the dark; each frame is drawn from three pictures.
constexpr const char* kShortWalk = R"(
walk: {commands: [{stand: {duration_s: 0.5}}, {tangent_arc: {radius_m: 0.75, angle_deg: 10}}]}
camera: {width_px: 160, height_px: 120, exposure_s: 0.01, readout_s: 0.02, subframes: 3}
world.lights_off: {from_s: 1, duration_s: 0.5}
slam: {}
limits: {ending: [completed]}
)";
const std::vector<std::string> kBlind{"camera", "slam"};

class RunTest : public tests::RunFolder {
 protected:
  using Words = std::vector<std::string>;
  static auto scenario(const Words& overrides = {}, const Words& without = {}) {
    return read(kShortWalk, overrides, without);
  }

  /// Leaves the result of run(name, scenario()); the tests of a process share the walk.
  void live(const std::string& name) const {
    if (!fs::exists(shared_)) {
      EXPECT_EQ(run(name, scenario()).exit_code, 0);
      fs::rename(folder_ / name, shared_);
    }
    fs::copy(shared_, folder_ / name, fs::copy_options::recursive);
  }
  static void TearDownTestSuite() { fs::remove_all(shared_); }
  void expect_checked(const std::string& name) const {
    EXPECT_EQ(json(name, "recording/self_check.json")["complaint"], "");
  }

  static inline const fs::path shared_ =
      fs::temp_directory_path() / ("gaitslam run " + std::to_string(getpid()));
};

TEST_F(RunTest, SameSeedGivesTheSameBitsHoweverImagesAreDrawnAndPassesTheSelfCheck) {
  live("one");
  ASSERT_EQ(run("two", scenario(), 2).exit_code, 0) << "images drawn in parallel with the walk";
  EXPECT_THAT(tests::differences(folder_ / "one", folder_ / "two"), IsEmpty());
  expect_checked("one");
}

TEST_F(RunTest, ReplayGivesTheLiveResultBitForBitButNotWithAnotherGyro) {
  live("live");
  ASSERT_EQ(replay("live", "replay", scenario()).ending, Ending::completed);
  EXPECT_THAT(changed_by_replay("live", "replay"), IsEmpty());
  replay("live", "noisy", scenario({"errors.gyro.sigma_rad_s=0.05"}));
  EXPECT_NE(file("live", "estimate.tum"), file("noisy", "estimate.tum"));
  EXPECT_EQ(file("live", "truth.tum"), file("noisy", "truth.tum"));
}

// Readings of all kinds, each kind at its own rate, are recorded and read back; the filter uses none of them.
TEST_F(RunTest, ARigIsRecordedWithTheSameBytesHoweverItIsDrawnAndChangesNoEstimate) {
  constexpr const char* kRig =
      "walk: {commands: [{stand: {duration_s: 0.5}}, {tangent_arc: {angle_deg: 10}}]}\n"
      "camera: {width_px: 160, height_px: 120}\nslam: {}\n"
      "rig: [{gray: {}}, {color: {width_px: 96, height_px: 64, rate_hz: 7, readout_s: 0.02}}, {depth: {}},\n"
      "  {depth: {name: depth1, aligned_with: rgb0}}, {imu: {rate_hz: 500}}, {lidar: {points_per_s: "
      "2000}}]\n";
  ASSERT_EQ(run("one", read(kRig)).ending, Ending::completed);
  ASSERT_EQ(run("two", read(kRig), 2).ending, Ending::completed) << "drawn in parallel with the walk";
  EXPECT_THAT(tests::differences(folder_ / "one", folder_ / "two"), IsEmpty());
  ASSERT_EQ(replay("one", "replay", read(kRig)).ending, Ending::completed);
  EXPECT_THAT(changed_by_replay("one", "replay"), IsEmpty());
  ASSERT_EQ(run("alone", read(kRig, {"rig=[]"})).ending, Ending::completed);
  for (const char* name : {"estimate.tum", "truth.tum", "map.csv"})
    EXPECT_EQ(file("one", name), file("alone", name)) << name;
  ASSERT_EQ(run("imus", read(kRig, {"rig=[{imu: {}}, {imu: {name: imu2}}]"})).ending, Ending::completed);
  sim::recording::RecordingReader reader(folder_ / "one" / "recording");
  const double end_s =
      slam::seconds(sim::recording::read_truth(folder_ / "one" / "recording").camera.back().t);
  std::vector<int> readings(6);
  slam::Stamp last_imu{0};
  while (const auto observation = reader.next())
    for (const slam::RigReading& reading : observation->rig) {
      ++readings.at(std::size_t(reading.sensor));
      EXPECT_LE(reading.t, observation->t);
      if (reading.sensor != 4) continue;
      EXPECT_EQ(reading.begin, last_imu) << "readings adjoin";
      last_imu = reading.t;
    }
  const std::vector<double> rates{30, 7, 30, 7, 500, 10};
  for (std::size_t i = 0; i < rates.size(); ++i) EXPECT_NEAR(readings[i], rates[i] * end_s, 2) << i;
}

// Also uses its plan instead of leg odometry.
TEST_F(RunTest, At640By480AWalkPassesItsCheckAndIsReplayedBitForBit) {
  constexpr const char* kLarge =
      "walk: {commands: [{stand: {duration_s: 0.5}}, {tangent_arc: {angle_deg: 10}}]}\n"
      "camera: {width_px: 640, height_px: 480}\nslam: {}\n";
  const auto by_plan = read(kLarge, {"slam.leg_odometry.enabled=false"});
  ASSERT_EQ(run("live", by_plan).ending, Ending::completed);
  ASSERT_EQ(replay("live", "replay", by_plan).ending, Ending::completed);
  EXPECT_THAT(changed_by_replay("live", "replay"), IsEmpty());
  expect_checked("live");
  EXPECT_GT(score("live", "track_completion"), 0.9);
  ASSERT_EQ(replay("live", "by legs", read(kLarge)).ending, Ending::completed);
  EXPECT_NE(file("replay", "estimate.tum"), file("by legs", "estimate.tum"));
}

TEST_F(RunTest, LeavesEveryFileOfACompleteResult) {
  live("live");
  for (const char* name :
       {"scenario.yaml", "about.json", "truth.tum", "plan.tum", "estimate.tum", "estimate_smoothed.tum",
        "waist_truth.tum", "waist_plan.tum", "estimate_cov.txt", "map.csv", "landmarks.csv", "frames.csv",
        "searches.csv", "timing.csv", "timing.json", "score.json", "recording/manifest.csv",
        "recording/mav0/cam0/data.csv"})
    EXPECT_TRUE(fs::exists(folder_ / "live" / name)) << name;
  for (const char* key : {"frame_cpu_ms_mean", "frame_cpu_ms_median", "frame_cpu_ms_p99", "realtime_factor"})
    EXPECT_GT(json("live", "timing.json")[key].get<double>(), 0) << key;
  EXPECT_EQ(json("live", "score.json")["metrics"]["loop_closed"]["reason"],
            "the camera never returned to a landmark after it had been elsewhere");
}

TEST_F(RunTest, TheWalkDependsOnSeedAndArmsButNotOnCameraAndFilter) {
  live("watched");
  EXPECT_EQ(run("blind", scenario({"limits.path_length_m.at_least=1000"}, kBlind)).exit_code, 1)
      << "a missed limit";
  EXPECT_EQ(file("watched", "truth.tum"), file("blind", "truth.tum"));
  EXPECT_FALSE(fs::exists(folder_ / "blind/estimate.tum"));
  EXPECT_TRUE(json("blind", "score.json")["metrics"]["ate_se3_rmse_m"]["value"].is_null());
  run("swing", scenario({"walk.arm_motion=swing"}, kBlind));
  EXPECT_NE(file("watched", "truth.tum"), file("swing", "truth.tum"));
  EXPECT_EQ(file("watched", "plan.tum"), file("swing", "plan.tum"));
  run("seed", scenario({"seed=2"}, kBlind));
  EXPECT_NE(file("watched", "truth.tum"), file("seed", "truth.tum"));
}

TEST_F(RunTest, AFallEndsTheRunWithACompleteFolderAndExitCodeThreeUnlessItIsAllowed) {
  const Outcome outcome = run("fall", scenario({"stabilizer.enabled=false", "world.floor_friction=0.05"}));
  EXPECT_EQ(outcome.ending, Ending::fell) << outcome.cause;
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(json("fall", "score.json")["ending"], "fell");
  EXPECT_TRUE(fs::exists(folder_ / "fall/recording/manifest.csv"));
  const Outcome allowed = run(
      "allowed",
      scenario({"stabilizer.enabled=false", "world.floor_friction=0.05", "limits.ending=[fell]"}, kBlind));
  EXPECT_EQ(allowed.ending, Ending::fell) << allowed.cause;
  EXPECT_EQ(allowed.exit_code, 0);
}

// A robot that is put on the floor sinks into its pads and bushings, shaking at up to 10 m/s². That is over
// before t = 0. A standing robot sways by less than 0.05 m/s².
TEST_F(RunTest, TheRecordingStartsAtRest) {
  for (const char* seed : {"seed=1", "seed=2", "seed=3"}) {
    run(seed, scenario({seed, "walk.commands=[{stand: {duration_s: 0.5}}]"}, kBlind));
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
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(RunTest, ADamagedRecordingIsRejectedAndLeavesNothingBehind) {
  live("live");
  std::ofstream(folder_ / "live/recording/mav0/imu0/data.csv", std::ios::app) << "1,2\n";
  EXPECT_THROW(replay("live", "replay", scenario()), sim::files::FileError);
  EXPECT_FALSE(fs::exists(folder_ / "replay"));
}

TEST(Constants, OfIndependentPartsAgree) {
  EXPECT_EQ(walking::kGravity, slam::kGravity);
  EXPECT_EQ(walking::kPeriod, 0.005);
  EXPECT_EQ(slam::kReadingPeriod_s, walking::kPeriod) << "a reading of the IMU lasts a tick of the plan";
  EXPECT_EQ(sim::recording::RecordingSetup{}.imu_rate_hz * walking::kPeriod, 1);
}

}  // namespace
