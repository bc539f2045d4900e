#include "sim/live/run.h"

#include <gmock/gmock.h>

#include <fstream>

#include "sim/replay/replay.h"
#include "tests/sim/result/result_folder.h"
#include "walking/hrp2.h"
#include "walking/plan.h"

namespace {

namespace fs = std::filesystem;
using sim::result::Outcome;
using sim::scenario::Ending;
using sim::scenario::ReadScenario;
using testing::IsEmpty;
using testing::Not;

// A few steps of the real walk, in the real office: long enough for every part of a run to have its say.
constexpr const char* kShortWalk = R"(
walk:
  commands:
    - stand: {duration_s: 0.5}
    - tangent_arc: {radius_m: 0.75, angle_deg: 25}
camera: {}
slam: {}
limits: {ending: [completed]}
)";

class RunTest : public testing::Test {
 protected:
  RunTest() { fs::create_directories(folder_); }
  ~RunTest() override { fs::remove_all(folder_); }

  static ReadScenario scenario(const std::vector<std::string>& overrides = {},
                               const std::vector<std::string>& without = {}) {
    return sim::scenario::read_scenario_text(kShortWalk, "short_walk.yaml", {overrides, without});
  }

  sim::result::ResultPlace place(const std::string& name) const {
    return {folder_ / name,
            sim::files::Existing::reject,
            fs::path(GAITSLAM_SOURCE_DIR) / "models",
            "1",
            "test",
            {}};
  }

  Outcome run(const std::string& name, const ReadScenario& read, int threads = 1) const {
    return sim::live::run(
        read, place(name), [](double) {}, threads);
  }

  /// Leaves what run(name, scenario()) leaves; the tests of a process share the walk.
  void live(const std::string& name) const {
    if (!fs::exists(shared_)) {
      EXPECT_EQ(run(name, scenario()).exit_code, 0);
      fs::rename(folder_ / name, shared_);
    }
    fs::copy(shared_, folder_ / name, fs::copy_options::recursive);
  }
  static void TearDownTestSuite() { fs::remove_all(shared_); }

  Outcome replay(const std::string& of, const std::string& name, const ReadScenario& read) const {
    return sim::replay::replay(read, folder_ / of / "recording", {{Ending::completed}}, place(name),
                               [](double) {});
  }

  const fs::path folder_ =
      fs::temp_directory_path() /
      ("gaitslam run " + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + " " +
       std::to_string(getpid()));
  static inline const fs::path shared_ =
      fs::temp_directory_path() / ("gaitslam run " + std::to_string(getpid()));
};

TEST_F(RunTest, SameSeedGivesTheSameBitsAndAnotherSeedOthers) {
  live("one");
  ASSERT_EQ(run("two", scenario(), 2).exit_code, 0) << "images drawn beside the walk";
  ASSERT_EQ(run("other", scenario({"seed=2"})).exit_code, 0);
  EXPECT_THAT(tests::differences(tests::files(folder_ / "one"), tests::files(folder_ / "two")), IsEmpty());
  EXPECT_NE(tests::files(folder_ / "one")["truth.tum"], tests::files(folder_ / "other")["truth.tum"]);
  EXPECT_NE(tests::files(folder_ / "one")["estimate.tum"], tests::files(folder_ / "other")["estimate.tum"]);
}

// Motion blur, rolling shutter and a dark half of a second, each frame drawn from three pictures; whatever
// the picture, it must pass the run's self check, which is given the true pose at the stamp alone.
TEST_F(RunTest, FramesWithEveryImageEffectAreTheSameBitsAndPassTheSelfCheck) {
  const ReadScenario read = scenario({"camera.exposure_s=0.01", "camera.readout_s=0.02", "camera.subframes=3",
                                      "world.lights_off.from_s=1", "world.lights_off.duration_s=0.5"});
  ASSERT_EQ(run("one", read).ending, Ending::completed);
  ASSERT_EQ(run("two", read, 2).ending, Ending::completed);
  EXPECT_THAT(tests::differences(tests::files(folder_ / "one"), tests::files(folder_ / "two")), IsEmpty());
  const nlohmann::json check = tests::json_of(folder_ / "one/recording/self_check.json");
  EXPECT_GE(check["view_px"]["points"], 30) << check;  // fewer are not judged
  EXPECT_LT(check["view_px"]["median"], check["view_px"]["at_most"]) << check;
}

TEST_F(RunTest, At640By480AWalkPassesItsCheckAndIsReplayedBitForBit) {
  const ReadScenario read = scenario({"camera.width_px=640", "camera.height_px=480"});
  ASSERT_EQ(run("live", read).ending, Ending::completed);
  ASSERT_EQ(replay("live", "replay", read).ending, Ending::completed);
  EXPECT_THAT(
      tests::differences(tests::files(folder_ / "live", "recording/"), tests::files(folder_ / "replay")),
      IsEmpty());
  const nlohmann::json check = tests::json_of(folder_ / "live/recording/self_check.json");
  EXPECT_GE(check["view_px"]["points"], 30) << check;
  EXPECT_LT(check["view_px"]["median"], check["view_px"]["at_most"]) << check;
  EXPECT_GT(tests::json_of(folder_ / "live/score.json")["metrics"]["track_completion"]["value"], 0.9);
}

TEST_F(RunTest, ReplayGivesTheLiveResultBitForBit) {
  live("live");
  ASSERT_EQ(replay("live", "replay", scenario()).ending, Ending::completed);
  EXPECT_THAT(
      tests::differences(tests::files(folder_ / "live", "recording/"), tests::files(folder_ / "replay")),
      IsEmpty());
}

TEST_F(RunTest, ByPlanAloneItIsAnotherResultThatIsReplayedBitForBitToo) {
  const ReadScenario by_plan = scenario({"slam.leg_odometry.enabled=false"});
  ASSERT_EQ(run("live", by_plan).ending, Ending::completed);
  ASSERT_EQ(replay("live", "replay", by_plan).ending, Ending::completed);
  EXPECT_THAT(
      tests::differences(tests::files(folder_ / "live", "recording/"), tests::files(folder_ / "replay")),
      IsEmpty());
  ASSERT_EQ(replay("live", "by legs", scenario()).ending, Ending::completed);
  EXPECT_NE(tests::files(folder_ / "replay")["estimate.tum"],
            tests::files(folder_ / "by legs")["estimate.tum"]);
}

TEST_F(RunTest, ReplayWithAnotherGyroIsAnotherResult) {
  live("live");
  replay("live", "replay", scenario({"errors.gyro.sigma_rad_s=0.05"}));
  EXPECT_NE(tests::files(folder_ / "live")["estimate.tum"], tests::files(folder_ / "replay")["estimate.tum"]);
  EXPECT_EQ(tests::files(folder_ / "live")["truth.tum"], tests::files(folder_ / "replay")["truth.tum"]);
}

TEST_F(RunTest, LeavesEveryFileOfACompleteResult) {
  live("live");
  for (const char* name :
       {"scenario.yaml", "about.json", "truth.tum", "plan.tum", "estimate.tum", "waist_truth.tum",
        "waist_plan.tum", "estimate_cov.txt", "map.csv", "landmarks.csv", "frames.csv", "searches.csv",
        "timing.csv", "timing.json", "score.json", "recording/manifest.csv", "recording/mav0/cam0/data.csv"})
    EXPECT_TRUE(fs::exists(folder_ / "live" / name)) << name;
  const nlohmann::json timing = tests::json_of(folder_ / "live/timing.json");
  for (const char* key : {"frame_cpu_ms_median", "frame_cpu_ms_p99", "realtime_factor"})
    EXPECT_GT(timing[key].get<double>(), 0) << key;
}

TEST_F(RunTest, TheWalkDoesNotDependOnCameraAndFilter) {
  live("watched");
  const Outcome outcome = run("alone", scenario({}, {"camera", "slam"}));
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(tests::files(folder_ / "watched")["truth.tum"], tests::files(folder_ / "alone")["truth.tum"]);
  EXPECT_FALSE(fs::exists(folder_ / "alone/estimate.tum"));
  EXPECT_TRUE(tests::json_of(folder_ / "alone/score.json")["metrics"]["ate_se3_rmse_m"]["value"].is_null());
}

TEST_F(RunTest, AFallEndsTheRunWithACompleteFolderAndExitCodeThree) {
  const Outcome outcome = run("fall", scenario({"stabilizer.enabled=false", "world.floor_friction=0.05"}));
  EXPECT_EQ(outcome.ending, Ending::fell) << outcome.cause;
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(tests::json_of(folder_ / "fall/score.json")["ending"], "fell");
  EXPECT_TRUE(fs::exists(folder_ / "fall/recording/manifest.csv"));
}

TEST_F(RunTest, AnEndingThatTheScenarioAllowsPasses) {
  const Outcome outcome =
      run("fall", scenario({"stabilizer.enabled=false", "world.floor_friction=0.05", "limits.ending=[fell]"},
                           {"camera", "slam"}));
  EXPECT_EQ(outcome.ending, Ending::fell) << outcome.cause;
  EXPECT_EQ(outcome.exit_code, 0);
}

// A robot that is put on the floor sinks into its pads and bushes, shaking at up to 10 m/s²: that is over
// before t = 0. Standing sways by less than 0.05 m/s²; the first step begins later.
TEST_F(RunTest, TheRecordingBeginsAtRest) {
  for (const char* seed : {"seed=1", "seed=2", "seed=3"}) {
    run(seed, scenario({seed}, {"camera", "slam"}));
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
    EXPECT_NEAR(truth.waist.front().X.translation().z(), walking::hrp2::kWaistHeight, 0.005);
    EXPECT_LT(truth.waist.front().X.translation().head<2>().norm(), 0.01);
  }
}

TEST_F(RunTest, SwingingArmsAreAnotherWalk) {
  run("still", scenario({}, {"camera", "slam"}));
  run("swing", scenario({"walk.arm_motion=swing"}, {"camera", "slam"}));
  EXPECT_NE(tests::files(folder_ / "still")["truth.tum"], tests::files(folder_ / "swing")["truth.tum"]);
  EXPECT_EQ(tests::files(folder_ / "still")["plan.tum"], tests::files(folder_ / "swing")["plan.tum"]);
}

TEST_F(RunTest, AMissedLimitIsExitCodeOne) {
  EXPECT_EQ(run("live", scenario({"limits.path_length_m.at_least=1000"}, {"camera", "slam"})).exit_code, 1);
}

TEST_F(RunTest, WhatCannotBeBegunLeavesNothingBehind) {
  EXPECT_ANY_THROW(run("no", scenario({"world.room=cellar"})));
  EXPECT_ANY_THROW(run("no", scenario({"world.robot=nobody"})));
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(RunTest, ADamagedRecordingIsRefusedAndLeavesNothingBehind) {
  live("live");
  std::ofstream(folder_ / "live/recording/mav0/imu0/data.csv", std::ios::app) << "1,2\n";
  EXPECT_THROW(replay("live", "replay", scenario()), sim::files::FileError);
  EXPECT_FALSE(fs::exists(folder_ / "replay"));
}

}  // namespace
