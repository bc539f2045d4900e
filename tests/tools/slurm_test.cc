// Commands on a Slurm cluster: three nodes on this machine (tools/slurm_local.sh), and one of shell scripts.
#include "tests/tools/command_line.h"

namespace tests {
namespace {

const std::string kTool = "'" GAITSLAM_SOURCE_DIR "/tools/slurm_local.sh' ";

// sbatch prints $NOTICE on standard error; the job is in $CLUSTER; with $HELD, no job starts; call number
// $HICCUP of squeue fails; its first calls print the lines of $STATES.
class ScriptedSlurm : public CommandLine {
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
echo "$id${CLUSTER:+;$CLUSTER}"
)sh");
    write("bin/squeue", R"sh(#!/bin/sh
echo call >>"$JOBS.calls"
calls=$(wc -l <"$JOBS.calls")
while [ $# -gt 0 ]; do case $1 in -j) id=$2 ;; -M) of=$2 ;; esac; shift; done
if [ "$calls" = "$HICCUP" ]; then
  echo "slurm_load_jobs error: Unable to contact slurm controller (connect failure)" >&2
  exit 1
fi
if [ "$of" != "$CLUSTER" ] || [ -n "$FORGOTTEN" ]; then
  echo "slurm_load_jobs error: Invalid job id specified" >&2
  exit 1
fi
[ -z "$of" ] || echo "CLUSTER: $of"
state=$(echo "$STATES" | sed -n "${calls}p")
[ ! -e "$JOBS/$id" ] || echo "${state:-RUNNING None}"
)sh");
    write("bin/sacct", R"sh(#!/bin/sh
while [ "$1" != -j ]; do shift; done
cat "$JOBS.sacct-$2"
)sh");
  }
  Ran on_slurm(const std::string& arguments, const std::string& settings = "") const {
    return shell(
        "mkdir -p jobs; chmod +x bin/*; export PATH=\"$PWD/bin:$PATH\" JOBS=\"$PWD/jobs\" "
        "GAITSLAM_SLURM_POLL_S=0.05; " +
        settings + " " GAITSLAM_PROGRAM " " + arguments);
  }
};

TEST_F(ScriptedSlurm, NothingIsSubmittedTwiceAfterANoticeOrAFailureOfSqueue) {
  for (const std::string settings :
       {"", "NOTICE='using the default partition'", "HICCUP=1", "HICCUP=2", "CLUSTER=alpha", "FORGOTTEN=1"}) {
    shell("rm -rf 'the cache' jobs jobs.calls");
    const Ran ran = on_slurm("record walk.yaml --seeds 1..3 --backend slurm", settings).ends(0);
    EXPECT_THAT(ran.out, Has("seed 3: recorded, completed")) << settings;
    EXPECT_THAT(ran.err,
                Has(settings == "CLUSTER=alpha" ? "slurm job 1000 of cluster alpha: " : "slurm job 1000: "));
    EXPECT_EQ(shell("ls jobs | cut -d. -f1").out, "1000\n") << settings;
  }
}

TEST_F(ScriptedSlurm, TheStateOfAWaitingJobIsPrintedWhenItChanges) {
  const std::string states = "PENDING Priority\nPENDING Priority\nPENDING JobHeldUser\nRUNNING None";
  EXPECT_THAT(
      on_slurm("record walk.yaml --backend slurm --seeds 1,2", "export STATES='" + states + "';").ends(0).err,
      Has("slurm job 1000: PENDING (Priority)\nslurm job 1000: PENDING (JobHeldUser)\n"
          "slurm job 1000: RUNNING\n"));
}

TEST_F(ScriptedSlurm, AJobUnknownToSqueueHasEndedOnlyIfTheAccountingSaysSo) {
  const std::string record = "record walk.yaml --seeds 1,2 --backend slurm",
                    forgotten = "HELD=1 FORGOTTEN=1 GAITSLAM_SLURM_POLL_S=0.001";
  EXPECT_THAT(on_slurm(record, forgotten).ends(2).err,
              Has("slurm job 1000: its state is unknown: slurm_load_jobs error: Invalid job id specified"));
  EXPECT_EQ(shell("ls jobs").out, "1000\n") << "nothing was submitted twice";
  write("jobs.sacct-1000", "CANCELLED by 0\nCOMPLETED\n");
  EXPECT_THAT(on_slurm(record, "FORGOTTEN=1").ends(0).out, Has("seed 2: recorded"));
  EXPECT_EQ(shell("ls jobs").out, "1000\n1001.ended\n");
}

TEST_F(ScriptedSlurm, AFailureWithoutAMessageIsReportedAndACommandThatEndsNamesTheArrayThatRuns) {
  const std::string record = "record walk.yaml --seeds 1,2 --backend slurm";
  EXPECT_THAT(
      on_slurm(record + " & until [ -e jobs.calls ]; do sleep 0.05; done; sleep 0.3; kill -TERM $!; wait $!",
               "HELD=1")
          .err,
      Has("gaitslam: interrupted: ", "slurm job 1000 still runs; to end it: scancel 1000\n"));
  write("bin/sbatch", "#!/bin/sh\nexit 3\n");
  shell("rm -rf 'the cache' jobs jobs.calls");
  EXPECT_THAT(on_slurm(record).ends(2).err,
              Has("sbatch: failed without a message (exit status 3), expected the id of a job"));
}

TEST_F(ScriptedSlurm, SeedsOfARunFormOneArrayAndASingleRunNone) {
  ok("run walk.yaml --seeds 1,2 --out here");
  const Ran ran = on_slurm("run walk.yaml --seeds 1,2 --out there --backend slurm").ends(0);
  EXPECT_THAT(ran.err, Has("slurm job 1000: "));
  EXPECT_THAT(differences(folder_ / "here", folder_ / "there"), IsEmpty());
  EXPECT_THAT(on_slurm("run walk.yaml --out one --backend slurm").ends(2).err, Has("expected --seeds"));
}

TEST_F(ScriptedSlurm, NothingOfAnArrayThatMayStillRunIsDeleted) {
  const std::string sweep = "sweep walk.yaml world.floor_friction=0.15,0.3 --out s --backend slurm ",
                    other = "sweep walk.yaml world.floor_friction=0.3,0.2 --out s --backend slurm --force";
  on_slurm(sweep + "& until [ -e jobs.calls ]; do sleep 0.05; done; kill -KILL $!; wait $!", "HELD=1");
  const std::string files = "find s -type f | grep -v -e .gaitslam | sort | xargs cksum",
                    before = shell("rm jobs.calls; " + files).out;
  EXPECT_THAT(before, Has("/element.sh"));
  for (const std::string settings : {"", "HICCUP=2"}) {
    EXPECT_THAT(on_slurm(other, settings).ends(2).err,
                Has("belongs to a Slurm job that may still run; wait for it, or end it: scancel 1000"));
    EXPECT_EQ(shell(files).out, before) << settings;
  }
  shell("mv jobs/1000 jobs/1000.ended");
  on_slurm(other).ends(0);
  EXPECT_FALSE(fs::exists(folder_ / "s/slurm"));
}

class LongSlurmTest : public CommandLine {
 protected:
  void SetUp() override {
    if (shell("command -v slurmctld munged").exit_code != 0)
      GTEST_SKIP() << "slurmctld or munged is not installed";
    if (getuid() != 0) GTEST_SKIP() << "tools/slurm_local.sh needs root";
    const int port = 20000 + 5 * (getpid() % 2000);  // one cluster per test
    ::setenv("GAITSLAM_SLURM_PORT", std::to_string(port).c_str(), 1);
    shell(kTool + "start " + cluster_).ends(0);
    ::setenv("SLURM_CONF", (cluster_ + "/slurm.conf").c_str(), 1);
    write("walk.yaml", scenario_of("{stand: {duration_s: 6}}"));
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
  const Ran there = shell(GAITSLAM_PROGRAM " " + sweep +
                          "--backend slurm --jobs 6 --out there & sweep=$!; until [ -n \"$(squeue -h -w n2 "
                          "-t R)\" ] && ls there/slurm/array/*.records; do sleep 0.1; done; " +
                          kTool + "lose " + cluster_ + " n2; wait $sweep");
  for (const Ran& ran : {here, there}) {
    EXPECT_EQ(ran.exit_code, 3);
    EXPECT_THAT(ran.err, Has("120 of 240 trials not started: "));
  }
  EXPECT_THAT(shell("sinfo -h -N -n n2 -o %T").out, Has("down"));
  EXPECT_THAT(shell("cat " + cluster_ + "/log/slurmctld.log").out, Has("equeue"))
      << "the node was lost too late";
  EXPECT_EQ(
      shell("cmp here/scores.csv there/scores.csv && cmp here/scores.jsonl there/scores.jsonl").exit_code, 0);
}

TEST_F(LongSlurmTest, AKilledCommandIsResumedByTheSameCommandAndSubmitsNothingTwice) {
  const std::string sweep = "sweep walk.yaml 'slam.vision.sigma_px={from: 1, to: 3, points: 40}' --out ";
  ok(sweep + "here");
  ended_when("ls there/slurm/array/*.records", "KILL", sweep + "there --backend slurm");
  const Ran again = gaitslam(sweep + "there --backend slurm").ends(0);
  EXPECT_EQ(again.err.find("slurm job"), std::string::npos) << "submitted again: " << again.err;
  EXPECT_EQ(text_of("here/scores.csv"), text_of("there/scores.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "there/slurm"));
}

}  // namespace
}  // namespace tests
