// The cache of recordings: made once, used by runs, suites and sweeps, with the bytes of runs without it.
#include <gmock/gmock.h>

#include "tests/sim/result/result_folder.h"
#include "tests/tools/command_line.h"

namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using tests::differences;
using tests::Ran;

class CacheTest : public tests::CommandLineWithCache {
 protected:
  CacheTest() { write("walk.yaml", tests::kStand); }
  std::string list() const { return gaitslam("cache list").out; }
};

TEST_F(CacheTest, RunsFromTheCacheHaveTheBytesOfARunAndShareARecordingOverSensorErrorsAndFilters) {
  const std::string keys =
      "errors.gyro.sigma_rad_s=0.05 errors.accelerometer.sigma_m_s2=0.5 slam.vision.sigma_px=3 ";
  ASSERT_EQ(gaitslam("record walk.yaml").exit_code, 0);
  const Ran ran = gaitslam("run walk.yaml " + keys + "--cached --out cached");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  ASSERT_EQ(gaitslam("run walk.yaml " + keys + "--out live").exit_code, 0);
  EXPECT_THAT(differences(folder_ / "live", folder_ / "cached"), IsEmpty());
  const std::string listed = list();
  EXPECT_THAT(listed, HasSubstr("walk seed 1"));
  EXPECT_EQ(std::count(listed.begin(), listed.end(), '\n'), 2) << "one recording and the sum";
}

TEST_F(CacheTest, EndingsOtherThanACompletedWalkAreTheSameFromTheCache) {
  const std::string fall =
      "world.pushes='[{push: {time_s: 0.05, impulse_ns: 300}}]' 'walk.commands=[{stand: {duration_s: 2}}]' ";
  const Ran live = gaitslam("run walk.yaml " + fall + "--out live");
  EXPECT_EQ(live.exit_code, 3);
  EXPECT_EQ(gaitslam("run walk.yaml " + fall + "--cached --out made").exit_code, 3);
  EXPECT_EQ(gaitslam("run walk.yaml " + fall + "--cached --out found").exit_code, 3);
  EXPECT_THAT(differences(folder_ / "live", folder_ / "made"), IsEmpty());
  EXPECT_THAT(differences(folder_ / "live", folder_ / "found"), IsEmpty());
  EXPECT_THAT(text_of("live/seed-1/about.json"), HasSubstr("fell"));
}

TEST_F(CacheTest, SeedsAreRecordedInProcessesAndOnlyWhereTheyAreMissing) {
  const Ran two = gaitslam("record walk.yaml --seeds 1,2 --jobs 2");
  EXPECT_EQ(two.exit_code, 0) << two.err;
  EXPECT_THAT(two.out, HasSubstr("seed 2: recorded, completed"));
  const Ran three = gaitslam("record walk.yaml --seeds 1..3");
  EXPECT_THAT(three.out, HasSubstr("seed 1: was in the cache"));
  EXPECT_THAT(three.out, HasSubstr("seed 3: recorded"));
  EXPECT_EQ(gaitslam("run walk.yaml --seeds 1..3 --cached --jobs 2").exit_code, 0);
  EXPECT_THAT(gaitslam("cache clean").out, HasSubstr("3 recordings removed"));
  EXPECT_THAT(list(), Not(HasSubstr("seed")));
  EXPECT_EQ(gaitslam("record walk.yaml --models nowhere").err, "gaitslam: nowhere: has no models\n");
  EXPECT_EQ(shell("GAITSLAM_CACHE_GB=much " GAITSLAM_PROGRAM " cache list").err,
            "gaitslam: GAITSLAM_CACHE_GB is 'much', expected a number of gigabytes\n");
}

TEST_F(CacheTest, ATuningMakesTheRecordingsThatItNeedsAndFindsThemAgain) {
  write("steps.yaml", "walk: {commands: [{straight: {forward_m: 0.1, left_m: 0}}]}\ncamera: {}\nslam: {}\n");
  write("spec.yaml",
        "parameters: {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.3, start: 0.1}}\n"
        "training: [{scenario: steps.yaml, seeds: 1..2}]\nholdout: [{scenario: steps.yaml, seeds: 3}]\n"
        "trials: 6\npopulation: 5\n");
  const Ran first = gaitslam("tune spec.yaml --out first --jobs 2");
  EXPECT_LE(first.exit_code, 1) << first.err;
  EXPECT_THAT(first.out, HasSubstr("pose_nll on hold-out"));
  EXPECT_THAT(text_of("first/tune.json"), HasSubstr("\"steps/seed-2\""));
  EXPECT_THAT(list(), HasSubstr("steps seed 3"));
  EXPECT_THAT(gaitslam("record steps.yaml --seeds 1..3").out, Not(HasSubstr(": recorded")));
  gaitslam("tune spec.yaml --out second");
  EXPECT_EQ(text_of("first/tune.json"), text_of("second/tune.json"));
  EXPECT_EQ(gaitslam("tune spec.yaml --out none --models nowhere").exit_code, 2);
}

TEST_F(CacheTest, ASuiteIsComparedWithItsBaselineFromTheCache) {
  write("suites/ci.yaml", "seeds: 1..2\nscenarios: [{scenario: ../walk.yaml}]\n");
  const Ran made = gaitslam("baseline update suites/ci.yaml --reason first --out made --jobs 2");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Ran again = gaitslam("regress suites/ci.yaml --out again --jobs 2 --cached");
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out,
              testing::AllOf(HasSubstr("2 seeds paired"), HasSubstr("IDENTICAL"), Not(HasSubstr("SAME"))));
}

}  // namespace
