// A sweep, recordings and a suite on a Slurm cluster of three nodes on this machine (tools/slurm_local.sh).
#include <gmock/gmock.h>

#include <cstdlib>

#include "tests/tools/command_line.h"

namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using tests::Ran;

constexpr const char* kSteps = R"(
walk: {commands: [{straight: {forward_m: 0.1, left_m: 0}}]}
camera: {}
slam: {}
)";

constexpr const char* kWalk = R"(
walk: {commands: [{stand: {duration_s: 6}}]}
camera: {}
slam: {}
)";

const std::string kTool = "'" GAITSLAM_SOURCE_DIR "/tools/slurm_local.sh' ";

class LongSlurmTest : public tests::CommandLineWithCache {
 protected:
  void SetUp() override {
    if (shell("command -v slurmctld munged").exit_code != 0)
      GTEST_SKIP() << "slurmctld or munged is not installed";
    if (getuid() != 0) GTEST_SKIP() << "tools/slurm_local.sh needs root";
    ::setenv("GAITSLAM_SLURM_PORT", std::to_string(20000 + 5 * (getpid() % 2000)).c_str(),
             1);  // one cluster per test
    const Ran started = shell(kTool + "start " + cluster_);
    ASSERT_EQ(started.exit_code, 0) << started.err;
    ::setenv("SLURM_CONF", (cluster_ + "/slurm.conf").c_str(), 1);
    write("walk.yaml", kWalk);
  }
  void TearDown() override {
    shell(kTool + "stop " + cluster_);
    fs::remove_all(cluster_);
    ::unsetenv("SLURM_CONF");
  }
  const std::string cluster_ =
      fs::temp_directory_path() / ("gaitslam-slurm-test-" + std::to_string(getpid()));
};

// Slurm fills its nodes one after another: the third array element runs on the second node.
TEST_F(LongSlurmTest, ASweepEndsAsItDoesHereThoughANodeIsLostAndSomeTrialsCannotBeTried) {
  const std::string sweep =
      "sweep walk.yaml walk.step_length_m=0.4 'slam.vision.sigma_px={from: 1, to: 3, points: 60}' "
      "'walk.commands=[{stand: {duration_s: 6}}],[{straight: {forward_m: 2}}]' --seeds 1,2 ";
  const Ran here = gaitslam(sweep + "--jobs 2 --out here");
  ASSERT_EQ(here.exit_code, 3);
  EXPECT_THAT(here.err, HasSubstr("120 of 240 trials not started: "));
  const Ran there =
      shell(GAITSLAM_PROGRAM " " + sweep +
            "--backend slurm --jobs 6 --out there & sweep=$!; until [ -n \"$(squeue -h -w n2 -t R)\" ] && ls "
            "there/parts/*.log; do sleep 0.1; done; " +
            kTool + "lose " + cluster_ + " n2; wait $sweep");
  EXPECT_EQ(there.exit_code, 3);
  EXPECT_THAT(there.err, HasSubstr("120 of 240 trials not started: "));
  EXPECT_THAT(shell("sinfo -h -N -n n2 -o %T").out, HasSubstr("down"));
  EXPECT_THAT(shell("cat " + cluster_ + "/log/slurmctld.log").out, HasSubstr("equeue"))
      << "the node was lost too late";
  EXPECT_FALSE(text_of("here/scores.csv").empty());
  EXPECT_EQ(text_of("here/scores.csv"), text_of("there/scores.csv"));
  EXPECT_EQ(text_of("here/scores.jsonl"), text_of("there/scores.jsonl"));
}

TEST_F(LongSlurmTest, AKilledCommandIsTakenUpByTheSameCommandAndSubmitsNothingTwice) {
  const std::string sweep = " sweep walk.yaml 'slam.vision.sigma_px={from: 1, to: 3, points: 40}' --out ";
  ASSERT_EQ(shell(GAITSLAM_PROGRAM + sweep + "here").exit_code, 0);
  shell(GAITSLAM_PROGRAM + sweep +
        "there --backend slurm & sweep=$!; until ls there/parts/*.log; do sleep 0.1; done; "
        "kill -9 $sweep; wait $sweep");
  const Ran again = shell(GAITSLAM_PROGRAM + sweep + "there --backend slurm");
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.err.find("slurm job"), std::string::npos) << "submitted again: " << again.err;
  EXPECT_EQ(text_of("here/scores.csv"), text_of("there/scores.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "there/slurm"));
}

TEST_F(LongSlurmTest, ATuningFromTheCacheEndsAsItDoesHereAlsoTakenUpByTheSameCommand) {
  write("steps.yaml", kSteps);
  write("spec.yaml",
        "parameters: {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.3, start: 0.29}}\n"
        "training: [{scenario: steps.yaml, seeds: 1..2}]\nholdout: [{scenario: steps.yaml, seeds: 3}]\n"
        "trials: 21\npopulation: 20\n");
  const Ran here = gaitslam("tune spec.yaml --jobs 2 --out here");
  ASSERT_EQ(here.exit_code, 0) << here.err;
  shell(GAITSLAM_PROGRAM
        " tune spec.yaml --out there --backend slurm & tune=$!; until ls there/parts/*.log; do sleep 0.1; "
        "done; "
        "kill -9 $tune; wait $tune");
  const Ran there = gaitslam("tune spec.yaml --out there --backend slurm --jobs 3");
  EXPECT_EQ(there.exit_code, 0) << there.err;
  EXPECT_EQ(shell("for file in best.yaml tune.json history.csv; do cmp here/$file there/$file || exit; done")
                .exit_code,
            0);
  EXPECT_FALSE(fs::exists(folder_ / "there/slurm"));
}

TEST_F(LongSlurmTest, WhyAHeldJobWaitsIsSaidOnce) {
  const Ran ran = shell(
      "timeout -s INT 15 " GAITSLAM_PROGRAM
      " record walk.yaml --seeds 1,2 --backend slurm & record=$!; "
      "until squeue -h -o %A | grep .; do sleep 0.1; done; scontrol hold \"$(squeue -h -o %A | head -n1)\"; "
      "wait $record");
  EXPECT_THAT(ran.err, HasSubstr("waits: JobHeld"));
  EXPECT_EQ(ran.err.find("waits:"), ran.err.rfind("waits:")) << ran.err;
  EXPECT_NE(shell("squeue -h").out, "") << "it stays in the queue";
}

TEST_F(LongSlurmTest, RecordingsAndASuiteAreMadeThere) {
  const Ran recorded = gaitslam("record walk.yaml --seeds 1..3 --backend slurm --jobs 3");
  EXPECT_EQ(recorded.exit_code, 0) << recorded.err;
  EXPECT_THAT(recorded.out, HasSubstr("seed 3: recorded, completed"));
  write("suites/ci.yaml", "seeds: 1..3\nscenarios: [{scenario: ../walk.yaml}]\n");
  ASSERT_EQ(gaitslam("baseline update suites/ci.yaml --cached --reason first").exit_code, 0);
  const Ran judged = gaitslam("regress suites/ci.yaml --cached --backend slurm --jobs 3");
  EXPECT_EQ(judged.exit_code, 0) << judged.err;
  EXPECT_THAT(judged.out, HasSubstr("IDENTICAL"));
}

}  // namespace
