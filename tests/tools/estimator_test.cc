// External estimators as a user runs them: in the loop, on recordings, and on exports.
#include <linux/landlock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "sim/files/csv.h"
#include "sim/files/trajectory_file.h"
#include "tests/tools/command_line.h"

namespace tests {
namespace {

class ExternalEstimator : public CommandLine {
 protected:
  ExternalEstimator() { short_walks("r"); }

  Ran replay(const std::string& estimator, const std::string& more = "") const {
    return gaitslam("replay r/seed-1 --out out --force \"estimator=" + estimator + "\" " + more);
  }
  std::set<std::string> names(const fs::path& folder) const {
    std::set<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder_ / folder)) all.insert(entry.path().filename());
    return all;
  }
};
using LongExternalEstimator = ExternalEstimator;

// The estimator is killed at these messages; 0 is the start.
TEST_F(ExternalEstimator, LeavesACompleteResultWhenKilledAtAnyMoment) {
  EXPECT_EQ(replay("filter").exit_code, 0);
  std::set<std::string> whole = names("out");
  whole.erase("estimate_smoothed.tum");  // only the filter has it
  for (const int message : {0, 1, 20, 45}) {
    EXPECT_THAT(
        replay(fmt::format("{{program: ['{}', killed, {}]}}", GAITSLAM_MISBEHAVING, message)).ends(3).err,
        Has("gaitslam: estimator_failed: the estimator misbehaving_program failed",
            "it was killed by signal 9"));
    const auto score = json_in("out/score.json"), metrics = score["metrics"];
    EXPECT_EQ(score["ending"], "estimator_failed");
    EXPECT_EQ(json_in("out/about.json")["walk_ending"], "completed");
    EXPECT_THAT(metrics["rmse_m"]["reason"].get<std::string>(), Has("the estimator failed: "));
    EXPECT_TRUE(metrics["path_length_m"]["value"].is_number());
    EXPECT_LT(metrics["tracked_fraction"]["value"], message / 40.0 + 0.01);
    EXPECT_EQ(names("out"), whole) << message;
  }
  replay(fmt::format("{{program: ['{}', openvins]}}", GAITSLAM_MISBEHAVING)).ends(0);
  // Four of 53 frames have no new pose: in two the estimator is not ready, in one it is lost, and one repeats
  // a pose.
  const auto tracked = json_in("out/score.json")["metrics"]["tracked_fraction"]["value"].get<double>();
  EXPECT_NEAR(tracked, 1 - 3 / 52.0, 0.002);
  replay(fmt::format("{{program: ['{}', gives_cause, 9], name: mine}}", GAITSLAM_MISBEHAVING)).ends(3);
  EXPECT_EQ(text_of("out/estimator.log"), "first\nthe map is broken\n");
  EXPECT_EQ(json_in("out/score.json")["estimator"], "mine");
  EXPECT_THAT(json_in("out/about.json")["cause"].get<std::string>(), Has("first | the map is broken"));
}

// Its log contains the names of the joints and the feet, then the readings.
TEST_F(ExternalEstimator, ReceivesEncodersAndForcesAsRecordedInARunAndItsReplay) {
  const std::string echoes =
      fmt::format(" \"estimator={{program: ['{}', echoes, 1, header]}}\"", GAITSLAM_MISBEHAVING);
  gaitslam("run walk.yaml --out run" + echoes);
  gaitslam("replay r/seed-1 --out out" + echoes);
  const std::string log = text_of("out/estimator.log");
  EXPECT_EQ(text_of("run/seed-1/estimator.log"), log);
  const std::string recording = (folder_ / "r/seed-1/recording/mav0/").string();
  sim::files::CsvReader encoders(recording + "encoders0/data.csv"), forces(recording + "forces0/data.csv");
  std::string names;
  for (std::size_t i = 1; i < encoders.titles().size(); ++i)
    names += encoders.titles()[i].substr(0, encoders.titles()[i].find('['));
  const std::size_t joints = encoders.titles().size() - 1, line = log.find('\n') + 1;
  EXPECT_EQ(log.substr(0, line), fmt::format("{}left right {}\n", names, joints + 12));
  std::istringstream lines(log.substr(line));
  int rows = 0;
  for (std::string field; std::getline(lines, field, ','); ++rows) {
    ASSERT_TRUE(encoders.next() && forces.next());
    EXPECT_EQ(std::stoll(field) + 1'000'000'000'000'000'000, encoders.integer(0));
    for (std::size_t i = 1; i <= joints + 12; ++i) {
      std::getline(lines, field, i < joints + 12 ? ',' : '\n');
      EXPECT_EQ(std::stod(field), i <= joints ? encoders.number(i) : forces.number(i - joints)) << rows;
    }
  }
  EXPECT_GT(rows, 200);
}

TEST_F(ExternalEstimator, ATimeModelIsReportedAndAMeasuredOneIsNotRepeatable) {
  const std::string fixed = "replay r/seed-1 --force 'estimator.time={model: fixed, frame_ms: 160}' --out ";
  EXPECT_THAT(gaitslam(fixed + "out").out, Has("time of the estimator fixed: "));
  EXPECT_TRUE(json_in("out/score.json")["estimator_time"]["repeatable"]);
  EXPECT_GT(metric(folder_ / "out", "dropped_frames_fraction"), 0.4);
  EXPECT_NEAR(metric(folder_ / "out", "tracked_fraction"),
              1 - metric(folder_ / "out", "dropped_frames_fraction"), 0.02);
  gaitslam(fixed + "again");
  EXPECT_EQ(text_of("out/score.json") + text_of("out/answers.csv"),
            text_of("again/score.json") + text_of("again/answers.csv"));
  ok("report out --out out.html");
  EXPECT_THAT(text_of("out.html"), Has("Latency and dropped frames"));
  EXPECT_THAT(gaitslam("replay r/seed-1 --force --out out estimator.time.model=measured").out,
              Has("time of the estimator measured, NOT REPEATABLE: "));
  EXPECT_FALSE(json_in("out/score.json")["estimator_time"]["repeatable"]);
}

// The bound is a tenth of the path. Without noise, the walk turns and moves as planned except for its slip.
TEST_F(ExternalEstimator, GyroAndPlanFollowsTheWalk) {
  ok("replay r/seed-1 --out out \"estimator={program: [/usr/bin/python3, " + kSources +
     "/tools/examples/gyro_and_plan.py]}\" errors.gyro.sigma_rad_s=0");
  EXPECT_LT(metric(folder_ / "out", "rmse_m"), metric(folder_ / "out", "path_length_m") / 10);
  EXPECT_EQ(json_in("out/score.json")["estimator"], "gyro_and_plan");
}

// The program adds a line to a file in its memory at each start.
TEST_F(ExternalEstimator, KeepsAFolderBetweenTheSessionsOfASeed) {
  write("keeps.py", "import os, sys\nlines = open('" + kSources +
                        "/tools/examples/gyro_and_plan.py').read().rsplit('main()', 1)[0]\nexec(lines)\n" +
                        R"(class Keeps(Estimator):
    def __init__(self, start):
        super().__init__(start)
        n = int.from_bytes(start[280:288], 'little')
        told = dict(line.split('=', 1) for line in start[288:288 + n].decode().splitlines())
        with open(told.pop('session.memory') + '/kept', 'a') as kept:
            print(int.from_bytes(start[272:280], 'little'), told, start[176:272].hex(), file=kept)
Estimator = Keeps
main()
)");
  write("sessions.yaml", kShortWalk + "estimator: {program: [/usr/bin/python3, keeps.py]}\n" +
                             "sessions: [session: {set: [world.start.x_m=0.5]}, session: {set: []}]\n");
  gaitslam("run sessions.yaml slam.map.start=unknown --seeds 1,2 --out s");
  const auto kept = [&](const std::string& result) {
    return sim::files::lines_of(text_of(result + "/memory/kept"));
  };
  const auto first = kept("s/seed-1/session-1"), last = kept("s/seed-1");
  ASSERT_EQ(first.size(), 1u);
  ASSERT_EQ(last.size(), 3u);
  EXPECT_EQ(last[0], first[0]);
  EXPECT_THAT(last[2],
              StartsWith("1 {'session.index': '3', 'session.count': '3', 'session.start': 'unknown'}"));
  EXPECT_NE(first[0].substr(first[0].rfind(' ')), last[2].substr(last[2].rfind(' ')))
      << "told exactly at first";
  EXPECT_THAT(kept("s/seed-2"), testing::SizeIs(3));
  EXPECT_THAT(kept("s/seed-2")[0], StartsWith("1000005 ")) << "the seed of its first session";
  EXPECT_NE(json_in("s/seed-1/about.json")["memory_xxh3_128"],
            json_in("s/seed-1/session-2/about.json")["memory_xxh3_128"]);
  gaitslam("replay s/seed-1 --scenario s/seed-1/scenario.yaml --out again");
  EXPECT_THAT(differences(folder_ / "s/seed-1", folder_ / "again", "recording/"), IsEmpty());
  expect_refused(
      "replay s/seed-1/session-2 --out alone --scenario s/seed-1/session-2/scenario.yaml",
      "session-2: is a session of a program with a memory, expected the result with all its sessions");
  EXPECT_THAT(gaitslam("sweep sessions.yaml slam.vision.sigma_px=1 --seeds 1 --out swept").ends(3).err,
              Has("sessions: a trial has no memory for an external program"));
}

// The command answers with the plan, in the world of its first session, which starts 0.5 m away.
TEST_F(ExternalEstimator, EvaluateAlignsAllSessionsAsTheFirst) {
  write("sessions.yaml",
        kShortWalk + "sessions: [session: {set: [world.start.x_m=0.5]}, session: {set: []}]\n");
  gaitslam("run sessions.yaml --out s");
  write("keeps.sh",
        "grep -v ^# $1/plan.txt | awk -v k=$3 '{ if (k > 1) $2 -= 0.5; print }' > $2; echo $3 >> $4/kept\n");
  gaitslam(
      "evaluate s/seed-1 --format tum --align none --out e --command 'sh keeps.sh {folder} {trajectory} "
      "{session} "
      "{memory}'");
  const std::string result = "e/sessions/seed-1";
  for (const char* session : {"/session-1", "/session-2", ""})
    EXPECT_LT(metric(folder_ / (result + session), "rmse_m"), 0.03) << "error of the plan" << session;
  EXPECT_EQ(text_of(result + "/memory/kept"), "1\n2\n3\n");
  EXPECT_EQ(metric(folder_ / result, "first_pose_correct"), 1);
  EXPECT_TRUE(std::isnan(metric(folder_ / (result + "/session-1"), "first_pose_correct"))) << "no memory yet";
}

TEST_F(ExternalEstimator, OfSessionsCannotKeepFilesElsewhere) {
  if (::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) < 2)
    GTEST_SKIP() << "the kernel has no Landlock";
  write("elsewhere.py", "open('kept', 'a').write('map')\n");
  write("sessions.yaml", kShortWalk + "sessions: [session: {set: []}]\n" +
                             "estimator: {program: [/usr/bin/python3, elsewhere.py]}\n");
  gaitslam("run sessions.yaml --out s").ends(3);
  EXPECT_THAT(text_of("s/seed-1/session-1/score.json"), Has("Permission denied: 'kept'"));
  EXPECT_FALSE(fs::exists(folder_ / "kept"));
}

TEST_F(ExternalEstimator, PlanAloneCompiledAsInTheReadmeGivesThePosesOfTheBuiltInOne) {
  const auto poses = [&](const std::string& program) {
    ok("replay r/seed-1 --out out --force estimator=" + program);
    return sim::files::read_tum(folder_ / "out/estimate.tum");
  };
  const auto built_in = poses("plan_alone");
  shell("ln -s '" + kSources + "/sim' . && cp '" + kSources +
        "/tools/examples/plan_alone.c' mine.c && cp mine.c mine.cc")
      .ends(0);
  for (const char* compiler : {"cc", "c++"}) {
    shell("eval \"$(sed -n 's|^    " + std::string(compiler) + " |" + compiler +
          " |p' sim/estimators/README.md)\"")
        .ends(0);
    EXPECT_THAT(shell("./mine < /dev/null").ends(2).err, Has("the standard input ends without END"));
    const auto compiled = poses("'{program: ./mine}'");
    ASSERT_EQ(compiled.size(), built_in.size());
    for (std::size_t i = 0; i < built_in.size(); ++i)
      EXPECT_TRUE(compiled[i].X.isApprox(built_in[i].X, 1e-9)) << i;
    shell("rm mine");
  }
}

TEST_F(ExternalEstimator, AProgramThatRejectsItsStartIsFoundBeforeTheWalk) {
  for (const auto& [behavior, cause] : {std::pair("cannot_start", "it cannot start: no vocabulary"),
                                        {"wrong_version", "it speaks version 99"}})
    for (const char* command : {"run walk.yaml", "replay r/seed-1"})
      expect_refused(fmt::format("{} --out h \"estimator={{program: ['{}', {}, 0], name: mine}}\"", command,
                                 GAITSLAM_MISBEHAVING, behavior),
                     std::string("estimator: mine: ") + cause);
  EXPECT_FALSE(fs::exists(folder_ / "h"));
}

/// The C++ program of tools/examples on a recording of a straight walk of 1 m. The bounds are a twentieth of
/// the path, chosen before the first try; a program that stands still misses them by far.
TEST_F(LongExternalEstimator, TheExampleTracksTheWalkByStereo) {
  for (const char* folder : {"sim", "tools"})
    fs::create_directory_symlink(kSources + "/" + folder, folder_ / folder);
  shell("eval \"$(sed -n 's|^// *c++ |c++ |p' tools/examples/visual_odometry.cc)\"").ends(0);  // its own line
  write("line.yaml",
        scenario_of("{stand: {duration_s: 0.5}}, {straight: {forward_m: 1, left_m: 0}}") + "rig: d435i\n");
  shell("rm -r r");
  ok("run line.yaml --out r estimator=plan_alone");
  const auto of_out = [&](const char* name) {
    const double value = metric(folder_ / "out", name);
    return std::isnan(value) ? HUGE_VAL : value;
  };
  const std::string frozen = "'errors.faults=[{frames_frozen: {from_s: 4.5, duration_s: 100}}]'",
                    nothing = fmt::format("['{}', nothing]", GAITSLAM_MISBEHAVING);
  for (const auto& [program, more, follows] :
       {std::tuple<std::string, std::string, bool>{"./visual_odometry", "", true},
        {"./visual_odometry", frozen, false},
        {nothing, "", false}}) {
    replay("{program: " + program + "}", more);
    const double ate_m = of_out("ate_se3_rmse_m"), bound_m = of_out("path_length_m") / 20;
    if (!follows) {
      EXPECT_GT(ate_m, 2 * bound_m) << program << more << ": it does not follow its images";
      continue;
    }
    EXPECT_LT(ate_m, bound_m) << program;
    EXPECT_LT(std::abs(of_out("scale_error_percent")), 5) << program;
    EXPECT_GT(of_out("tracked_fraction"), 0.95) << program;
    EXPECT_GT(text_of("out/map.csv").size(), 2000u) << program;
  }
  ok("evaluate r/seed-1 --format tum --out e --command 'grep -v ^# {folder}/plan.txt > {trajectory}'");
  EXPECT_EQ(json_in("e/line/seed-1/about.json")["alignment"], "se3") << "stereo has a scale";
}

// The estimator starts another process in a new session, waits and never answers.
TEST_F(ExternalEstimator, LeavesNoProcessAndNoPartialResultWhenInterrupted) {
  write("starter.sh", "#!/bin/sh\nsetsid sleep 1000 &\necho $! > theirs\necho $$ > its\nwait\n");
  for (const char* signal : {"INT", "TERM", "KILL"})
    for (const std::string command :
         {"replay r/seed-1 --out h 'estimator={program: [sh, starter.sh]}'",
          "run walk.yaml --out h 'estimator={program: [sh, starter.sh]}'",
          "evaluate r/seed-1 --out h --format tum --command 'sh starter.sh # {trajectory}'"}) {
      const Ran ran = shell("rm -f its theirs; env --default-signal=INT " GAITSLAM_PROGRAM " " + command +
                            " & bench=$!; until [ -s its ]; do sleep 0.01; done; kill -" + signal +
                            " $bench; wait $bench; alive() { grep -q 'State:.[^ZX]' /proc/$1/status "
                            "2>/dev/null; }; for k in $(seq 300); do alive $(cat its) || alive $(cat theirs) "
                            "|| exit 0; sleep 0.01; done; kill -9 $(cat theirs); exit 77");
      EXPECT_EQ(ran.exit_code, 0) << signal << " " << command << ran.err;
      const Ran left = shell("find h -name score.json; rm -rf h");
      EXPECT_EQ(left.out, "") << signal << " " << command;
    }
}

TEST_F(ExternalEstimator, ProcessesThatItStartedEndWithIt) {
  write("leaver.sh", "setsid sleep 1000 &\necho $! > theirs\ngrep -v '^#' \"$1/plan.txt\" > \"$2\"\n");
  ok("evaluate r/seed-1 --out h --format tum --command 'sh leaver.sh {folder} {trajectory}'");
  EXPECT_NE(shell("grep -q 'State:.[^ZX]' /proc/$(cat theirs)/status").exit_code, 0);
}

TEST_F(ExternalEstimator, AWalkSteeredByAChangedProgramIsRecordedAgain) {
  write("walk.yaml", kShortWalk + "estimator: {program: [/usr/bin/python3, gyro.py]}\n");
  write("steered.yaml", "base: walk.yaml\nwalk: {steering: {by: estimate}}\n");
  fs::copy(kSources + "/tools/examples/gyro_and_plan.py", folder_ / "gyro.py");
  const auto recorded = [&](const std::string& scenario) {
    return ok("record " + scenario).find("seed 1: recorded, completed") != std::string::npos;
  };
  EXPECT_TRUE(recorded("walk.yaml"));
  EXPECT_TRUE(recorded("steered.yaml"));
  EXPECT_FALSE(recorded("steered.yaml"));
  write("gyro.py", text_of("gyro.py") + "# another program\n");
  EXPECT_TRUE(recorded("steered.yaml"));
  EXPECT_FALSE(recorded("walk.yaml"));  // nothing steers it
}

TEST_F(ExternalEstimator, AProgramNamedOnlyByTheResultIsNotStarted) {
  ASSERT_EQ(replay("{program: [/usr/bin/touch, started]}").exit_code, 3);
  shell("mv out received && cp -r r/seed-1/recording received && rm started");
  const std::string again = "replay received --out out ";
  expect_refused({{again + "slam.gyro.sigma_rad_s=0.02", "gaitslam: received/scenario.yaml:"},
                  {again, R"(: estimator: is {program: ["/usr/bin/touch", started])"},
                  {again,
                   "which a replay starts only if the command line names it, expected --scenario "
                   "received/scenario.yaml or estimator=filter\n"}});
  ok(again + "estimator=plan_alone");
  EXPECT_FALSE(fs::exists(folder_ / "started"));
  EXPECT_EQ(gaitslam(again + "--force --scenario received/scenario.yaml").exit_code, 3);
  EXPECT_TRUE(fs::exists(folder_ / "started"));
  EXPECT_EQ(json_in("out/about.json")["set_by"], json_in("received/about.json")["set_by"]);
}

TEST_F(ExternalEstimator, EvaluateRunsAProgramOnSeveralRecordings) {
  short_walks("more", "2 3");
  ok("evaluate r/seed-1 more/seed-2 more/seed-3 --format tum --align none --out e --command '" + kSources +
     "/tools/examples/plan_alone.sh {folder} {trajectory}'");
  ASSERT_EQ(replay("plan_alone").exit_code, 0);
  const auto evaluated = json_in("e/walk/seed-1/score.json"), metrics = evaluated["metrics"];
  EXPECT_EQ(json_in("e/walk/seed-1/about.json")["alignment"], "none");
  EXPECT_EQ(evaluated["estimator"], "plan_alone_external");
  const auto timing = json_in("e/walk/seed-1/timing.json");  // times of the whole command
  EXPECT_GT(timing["frame_cpu_ms_mean"], 0);
  EXPECT_FALSE(timing.contains("frame_cpu_ms_median"));
  EXPECT_EQ(metrics["tracked_fraction"]["value"], 1);
  EXPECT_NEAR(metrics["rmse_m"]["value"], metric(folder_ / "out", "rmse_m"), 1e-9);
  EXPECT_TRUE(fs::exists(folder_ / "e/walk/seed-3/timing.json"));
}

TEST_F(ExternalEstimator, EvaluateReadsCovariancesAppliesLimitsAndStatesTheCoverage) {
  write("late.sh",
        "awk '/^[0-9]/ && ++n > 12 {print $0, \"1e-4 0 0 1e-4 0 1e-4 1e-4 0 0 1e-4 0 1e-4\"}' "
        "r/seed-1/truth.tum > $1\n");
  const std::string evaluate =
      "evaluate r/seed-1 --format tum --align none --keep --force --out e --command 'sh late.sh "
      "{trajectory}'";
  ok(evaluate);
  const auto metrics = json_in("e/walk/seed-1/score.json")["metrics"];
  EXPECT_NEAR(metrics["nees_position_mean"]["value"].get<double>(), 0, 1e-9);
  EXPECT_GT(metrics["poses_with_covariance"]["value"], 0);
  EXPECT_LT(metrics["tracked_fraction"]["value"], 0.95) << "it begins late";
  EXPECT_TRUE(metrics["loop_closed"]["value"].is_null());
  EXPECT_TRUE(fs::exists(folder_ / "e/walk/seed-1/trajectory.txt"));
  EXPECT_THAT(metrics["ate_se3_rmse_m"]["note"], Has(" true poses"));
  EXPECT_EQ(gaitslam(evaluate + " limits.tracked_fraction.at_least=0.99").exit_code, 1);
  const std::string by_default =
      "evaluate r/seed-1 --format tum --force --out e --command 'sh late.sh {trajectory}'";
  EXPECT_THAT(ok(by_default), Has("\n  ate_se3_rmse_m  ", "\n  ate_sim3_rmse_m  "));
  EXPECT_EQ(json_in("e/walk/seed-1/about.json")["alignment"], "se3");
  EXPECT_TRUE(json_in("e/walk/seed-1/score.json")["metrics"]["rmse_m"]["value"].is_number());
  ok(by_default + " --align sim3");
  const auto scaled = json_in("e/walk/seed-1/score.json")["metrics"];
  EXPECT_THAT(scaled["rmse_m"]["reason"], Has("was scaled by 1 to the truth"));
  EXPECT_TRUE(scaled["ate_se3_rmse_m"]["value"].is_number());
  expect_refused(evaluate + " slam.gyro.sigma_rad_s=1", "only limits may be changed");
  write("late.sh", "echo no trajectory > $1\n");
  EXPECT_EQ(gaitslam(evaluate).exit_code, 3);
  EXPECT_EQ(text_of("e/walk/seed-1/trajectory.txt"), "no trajectory\n") << "kept, though it was rejected";
  write("late.sh", "grep -v '#' r/seed-1/truth.tum | tr ' ' , > $1\n");
  EXPECT_THAT(gaitslam(evaluate).ends(3).err, Has("no header names the comma-separated columns"));
  ok(evaluate + " --columns 't[s] x y z qx qy qz qw'");
  write("late.sh", "grep -v '#' r/seed-1/truth.tum | awk '{$1 = NR - 1} 1' > $1\n");
  EXPECT_THAT(gaitslam(evaluate).ends(3).err, Has("its stamps are whole numbers, like frame numbers"));
}

TEST_F(ExternalEstimator, AnInterruptedEvaluationContinuesWithTheRemainingRecordings) {
  short_walks("r", "2");
  write("plan.sh",
        "echo >> runs; [ -e go ] || [ $(wc -l < runs) = 1 ] || sleep 1000; grep -v '^#' \"$1/plan.txt\" > "
        "\"$2\"\n");
  const std::string evaluate =
      "evaluate r/seed-1 r/seed-2 --format tum --out e --command 'sh plan.sh {folder} {trajectory}'";
  ended_when("[ \"$(wc -l < runs)\" = 2 ]", "KILL", evaluate);
  write("go", "");
  EXPECT_THAT(ok(evaluate), Has("1 result finished before\n"));
  EXPECT_EQ(text_of("runs"), "\n\n\n");
  EXPECT_TRUE(fs::exists(folder_ / "e/walk/seed-2/score.json"));
}

TEST_F(ExternalEstimator, EvaluateReplacesNothingThatItReadsAndAnEarlierResultOnlyByForce) {
  short_walks("results/walk", "1 2");
  for (const std::string recordings :
       {"seed-1 --out results", "seed-* --out results", "seed-1 --out results --force"})
    expect_refused(
        "evaluate --format tum --name other --command 'false # {trajectory}' results/walk/" + recordings,
        "walk/seed-1: would be replaced, but the command reads ");
  EXPECT_TRUE(fs::exists(folder_ / "results/walk/seed-1/recording"));

  short_walks("r", "2");
  const std::string plan =
      " --format tum --out e --command 'grep -v \"^#\" {folder}/plan.txt > {trajectory}'";
  ok("evaluate r/seed-1" + plan);
  const auto made = [&] { return fs::last_write_time(folder_ / "e/walk/seed-1/score.json"); };
  const auto first = made();
  expect_refused("evaluate r/seed-1" + plan, "e/walk/seed-1: already exists; --force replaces it");
  EXPECT_THAT(ok("evaluate r/seed-2 r/seed-1" + plan), Has("1 result finished before"));
  EXPECT_EQ(made(), first);
  expect_refused("evaluate r/seed-2 r/seed-1 limits.rmse_m.at_most=9" + plan,
                 "e/walk/seed-2: exists, but its limits or name differ; --force replaces it");
  ok("evaluate r/seed-1 r/seed-2 --force" + plan);
  EXPECT_NE(made(), first) << "its program need not do the same again";
}

TEST_F(ExternalEstimator, ACommandGetsNoTruthAndIsEndedAtItsTimeLimit) {
  const std::string evaluate = "evaluate r/seed-1 --out e --force --format ";
  for (const std::string format : {"euroc", "openvins", "orbslam3", "tum"}) {
    const Ran ran =
        gaitslam(evaluate + format + " --command 'rm -rf kept; cp -r {folder} kept && false # {trajectory}'");
    EXPECT_EQ(ran.exit_code, 3) << ran.err;
    EXPECT_THAT(ran.err, Has("estimator_failed: the command failed: it ended with exit code 1"));
    EXPECT_EQ(shell("find kept | grep -i -E 'truth|poses|estimate.txt'").out, "") << format;
  }
  EXPECT_THAT(gaitslam(evaluate + "tum --within 0.5 --command 'sleep 1000 # {trajectory}'").ends(3).err,
              Has("it did not exit within 0.5 s"));
}

TEST_F(ExternalEstimator, EstimatorsAreShownSideBySideAndScenariosSeparately) {
  short_walks("tree/filter", "1 2");
  write("other.yaml", "base: walk.yaml\nworld.room: hall\n");
  ok("run walk.yaml --seeds 1,2 estimator=plan_alone --out tree/plan");
  ok("run other.yaml --out tree/hall");
  ok("report tree tree/filter --table t.csv --out t.html");
  EXPECT_THAT(text_of("t.csv"),
              Has("\nother,,filter,plan,hrp2,,1,1,1,rmse_m,", "\nwalk,,filter,plan,hrp2,,2,2,1,rmse_m,",
                  "\nwalk,,plan_alone,plan,hrp2,,2,2,1,rmse_m,"));
  EXPECT_THAT(text_of("t.html"),
              Has("<h2>other: all runs</h2>", "<th>estimator</th><th class='number'>ATE [mm]"));
  expect_refused("report tree --table t.csv", "already exists; --force replaces it");

  EXPECT_THAT(gaitslam("compare tree/filter tree/plan").out,
              Has("tree/filter (baseline) and tree/plan (now, plan_alone)"));
  ok("report tree/filter tree/plan tree/hall --plots svg --out figures");
  EXPECT_THAT(text_of("figures/error_over_time_walk.svg"), Has("plan_alone"));
  EXPECT_FALSE(
      fs::exists(folder_ / "figures/error_over_time_other.svg"));      // one run has nothing to compare with
  EXPECT_FALSE(fs::exists(folder_ / "figures/error_over_seeds.svg"));  // nothing is pooled over estimators
}

TEST_F(ExternalEstimator, EvaluateRefusesWhatItCannotDo) {
  const std::string tum = "evaluate r/seed-1 --format tum --out e ";
  expect_refused(
      {{tum + "--command true", "lacks {trajectory}, expected it"},
       {"evaluate r/seed-1 --format tmu --command '{trajectory}' --out e", "did you mean 'tum'?"},
       {tum + "--command 'x {memory} {trajectory}'", "r/seed-1: has no sessions, expected some for {memory}"},
       {"evaluate r --format tum --command '{trajectory}' --out e", "expected the folder of a run"},
       {tum + "--pose head --command '{trajectory}'", "expected camera or imu"}});
}

}  // namespace
}  // namespace tests
