// Commands on a Slurm cluster: of three nodes on this machine (tools/slurm_local.sh), and one of shell
// scripts.
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

// $NOTICE is printed by sbatch on standard error, with $HELD the job does not start, and the call of squeue
// with the number $HICCUP fails.
class ScriptedSlurm : public tests::CommandLineWithCache {
 protected:
  ScriptedSlurm() {
    write("walk.yaml", "walk: {commands: [{stand: {duration_s: 0.2}}]}\nworld: {room: floor}\n");
    write("bin/sbatch", R"sh(#!/bin/sh
[ -z "$NOTICE" ] || echo "sbatch: $NOTICE" >&2
for word; do case $word in --array=*) elements=${word#--array=} ;; esac; done
while [ $# -gt 3 ]; do shift; done
id=$((1000 + $(ls "$JOBS" | wc -l)))
touch "$JOBS/$id"
[ -n "$HELD" ] || (for element in $(echo "${elements%%%*}" | tr , ' '); do SLURM_ARRAY_TASK_ID=$element sh "$@"; done
mv "$JOBS/$id" "$JOBS/$id.ended") >/dev/null 2>&1 &
echo $id
)sh");
    write("bin/squeue", R"sh(#!/bin/sh
echo call >>"$JOBS.calls"
if [ "$(wc -l <"$JOBS.calls")" = "$HICCUP" ]; then
  echo "slurm_load_jobs error: Unable to contact slurm controller (connect failure)" >&2
  exit 1
fi
[ ! -e "$JOBS/$3" ] || echo "RUNNING None"
)sh");
    write("bin/scontrol", "#!/bin/sh\necho 'MaxArraySize            = 1001'\n");
  }
  Ran on_slurm(const std::string& arguments, const std::string& settings = "") const {
    return shell("mkdir -p jobs; chmod +x bin/*; export PATH=\"$PWD/bin:$PATH\" JOBS=\"$PWD/jobs\"; " +
                 settings + " " GAITSLAM_PROGRAM " " + arguments);
  }
};

TEST_F(ScriptedSlurm, ANoticeOrAFailingSqueueSubmitsNothingTwice) {
  for (const std::string settings : {"", "NOTICE='using the default partition'", "HICCUP=1", "HICCUP=2"}) {
    shell("rm -rf 'the cache' jobs jobs.calls");
    const Ran ran = on_slurm("record walk.yaml --seeds 1..3 --backend slurm", settings);
    EXPECT_EQ(ran.exit_code, 0) << settings << ran.err;
    EXPECT_THAT(ran.out, HasSubstr("seed 3: recorded, completed")) << settings;
    EXPECT_THAT(ran.err, HasSubstr("slurm job 1000: ")) << settings;
    EXPECT_EQ(shell("ls jobs").out, "1000.ended\n") << settings;
  }
}

TEST_F(ScriptedSlurm, NothingOfAnArrayThatMayStillRunIsDeleted) {
  const std::string sweep = "sweep walk.yaml world.floor_friction=0.15,0.3 --out s --backend slurm ";
  on_slurm(sweep, "HELD=1 timeout -s KILL 5");
  const std::string files = "find s -type f | grep -v -e .unfinished -e .gaitslam | sort | xargs cksum",
                    before = shell("rm jobs.calls; " + files).out;
  EXPECT_THAT(before, HasSubstr("/element.sh"));
  for (const std::string settings : {"", "HICCUP=2"}) {
    const Ran ran = on_slurm(sweep + "--force", settings);
    EXPECT_EQ(ran.exit_code, 2);
    EXPECT_THAT(ran.err, HasSubstr("belongs to the Slurm job 1000, which may still run"));
    EXPECT_EQ(shell(files).out, before) << settings;
  }
  shell("mv jobs/1000 jobs/1000.ended");
  const Ran ran = on_slurm(sweep + "--force");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_FALSE(fs::exists(folder_ / "s/slurm"));
}

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
