// Several seeds through the program: the number of processes changes no file, and a crash ends one seed only.
#include <gmock/gmock.h>

#include "tests/sim/result/result_folder.h"
#include "tests/tools/command_line.h"

namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using tests::differences;
using tests::Ran;

const std::string kWalk =
    std::string(tests::kShortWalk) + "limits: {path_length_m.worst: {at_least: 0.01}}\n";

class BatchTest : public tests::CommandLine {
 protected:
  BatchTest() {
    write("walk.yaml", kWalk);
    write("stand.yaml", tests::kStand);
  }
};

// With image effects: several pictures a frame.
TEST_F(BatchTest, TheNumberOfJobsChangesNoByteAndASeedOfABatchIsThatSeedRunAlone) {
  const std::string run =
      "run walk.yaml camera.exposure_s=0.01 camera.readout_s=0.02 camera.subframes=2 "
      "world.lights_off.from_s=0.3 world.lights_off.duration_s=0.3 ";
  ASSERT_EQ(gaitslam(run + "--seeds 1..2 --jobs 1 --out one").exit_code, 0);
  ASSERT_EQ(gaitslam(run + "--seeds 1..2 --jobs 2 --out two").exit_code, 0);
  ASSERT_EQ(gaitslam(run + "seed=2 --out alone").exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "one/seed-1/recording/mav0/cam0/data"));
  EXPECT_THAT(differences(folder_ / "one", folder_ / "two"), IsEmpty());
  EXPECT_THAT(differences(folder_ / "one/seed-2", folder_ / "alone/seed-2"), IsEmpty());
  EXPECT_GT(std::filesystem::file_size(folder_ / "one/summary.json"), 0u);
}

TEST_F(BatchTest, ReplayOfAResultGivesItsBytes) {
  short_walks("results/walk");
  const Ran ran = gaitslam("replay results/walk/seed-1 --out again");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(differences(folder_ / "results/walk/seed-1", folder_ / "again", "recording/"), IsEmpty());
  EXPECT_EQ(gaitslam("replay results/walk/seed-1 --out again").exit_code, 2);
  EXPECT_EQ(gaitslam("replay results/walk/seed-1 --out again --force").exit_code, 0);
}

TEST_F(BatchTest, ARecordingIsReplayedWithAnotherScenarioOfTheSameWalk) {
  short_walks("results/walk");
  write("loud.yaml", kWalk + "errors: {gyro: {sigma_rad_s: 0.1}}\nname: walk\n");
  EXPECT_EQ(gaitslam("replay results/walk/seed-1 --scenario walk.yaml --out same").exit_code, 0);
  EXPECT_EQ(gaitslam("replay results/walk/seed-1 --scenario loud.yaml --out loud").exit_code, 0);
  EXPECT_EQ(gaitslam("compare results/walk same").out.find("SAME"), std::string::npos);
  EXPECT_NE(text_of("loud/estimate.tum"), text_of("same/estimate.tum"));
  write("other.yaml", "walk: {commands: [{stand: {duration_s: 2}}]}\ncamera: {}\nslam: {}\n");
  const Ran ran = gaitslam("replay results/walk/seed-1 --scenario other.yaml --out other");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_THAT(ran.err, HasSubstr("other.yaml: walk.commands is"));
}

// In a container the program that starts a batch is often process 1.
TEST_F(BatchTest, RunsWhereTheBatchIsTheFirstProcess) {
  if (shell("unshare --user --pid --fork true").exit_code != 0) GTEST_SKIP() << "no namespaces here";
  const Ran ran = shell("unshare --user --pid --fork " GAITSLAM_PROGRAM
                        " run stand.yaml --without camera,slam --seeds 1,2 --out first");
  EXPECT_EQ(ran.exit_code, 0) << ran.out << ran.err;
}

TEST_F(BatchTest, WhatSeveralSeedsSayAlikeIsSaidOnce) {
  const Ran ran = gaitslam(
      "run walk.yaml --without camera,slam --seeds 1..3 --out none world.room=floor "
      "'world.pushes=[{push: {time_s: 0.1, impulse_ns: 300}}]'");
  EXPECT_EQ(ran.exit_code, 3);
  EXPECT_THAT(ran.err, HasSubstr("seeds 1, 2, 3: gaitslam: fell: "));
  EXPECT_EQ(ran.err.find("fell"), ran.err.rfind("fell")) << ran.err;
}

}  // namespace
