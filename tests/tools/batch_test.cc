// Runs, replays, recordings and sweeps through the program: the same bytes for any number of processes, from
// the cache of recordings and after being killed; output as text, as one JSON document, or none; a filter
// that cannot see. Old results stay until new ones are complete, a rerun resumes, and only folders created by
// gaitslam are replaced.
#include "tests/tools/command_line.h"

namespace tests {
namespace {

const std::string kWalk =
    kShortWalk + "limits: {path_length_m.worst: {at_least: 0.01}, rmse_m: {at_most: 1}}\n";

class BatchTest : public CommandLine {
 protected:
  BatchTest() {
    write("walk.yaml", kWalk);
    write("stand.yaml", kStand);
  }
  std::string cached() const { return shell("find 'the cache' -name entry.json").out; }
  void expect_same(const std::string& a, const std::string& b, const std::string& without = "-") const {
    EXPECT_THAT(differences(folder_ / a, folder_ / b, without), IsEmpty()) << a << " and " << b;
  }

  /// The JSON document that a command prints, checked against its schema.
  json document_of(const std::string& arguments, const std::string& schema) const {
    const Ran ran = gaitslam(arguments).ends(0);
    EXPECT_EQ(ran.complaints(), "");
    write("printed.json", ran.out);
    checked(schema, "printed.json").ends(0);
    return json::parse(ran.out);
  }
};

// With image effects, so that each frame takes several pictures.
TEST_F(BatchTest, TheNumberOfJobsChangesNoByteAndASeedInABatchEqualsThatSeedRunAlone) {
  const std::string run =
      "run walk.yaml camera.exposure_s=0.01 camera.readout_s=0.02 camera.subframes=2 "
      "world.lights_off.from_s=0.3 world.lights_off.duration_s=0.3 ";
  ok(run + "--seeds 1..2 --jobs 1 --out one");
  ok(run + "--seeds 1..2 --jobs 2 --out two");
  ok(run + "seed=2 --out single");
  EXPECT_TRUE(fs::exists(folder_ / "one/seed-1/recording/mav0/cam0/data"));
  expect_same("one", "two");
  expect_same("one/seed-2", "single/seed-2");
  EXPECT_GT(fs::file_size(folder_ / "one/summary.json"), 0u);
}

TEST_F(BatchTest, AReplayGivesTheSameBytesAndAcceptsAnotherScenarioOfTheSameWalk) {
  short_walks("results/walk");
  const std::string replay = "replay results/walk/seed-1 --out ";
  write("loud.yaml", kShortWalk + "errors: {gyro: {sigma_rad_s: 0.02}}\nname: walk\n");
  ok(replay + "same --scenario walk.yaml");
  expect_refused(replay + "same", "same: already exists; --force replaces it");
  ok(replay + "same --force");
  expect_same("results/walk/seed-1", "same", "recording/");
  ok(replay + "loud --scenario loud.yaml");
  EXPECT_NE(text_of("loud/estimate.tum"), text_of("same/estimate.tum"));
  write("other.yaml", scenario_of("{stand: {duration_s: 2}}"));
  const Ran other = gaitslam(replay + "other --scenario other.yaml").ends(2);
  EXPECT_THAT(other.err, Has("other.yaml: walk.commands is"));
}

/// Three sessions of a step, with images in which the filter sees little.
const std::string kSessions =
    "walk: {commands: [" + kStep +
    "]}\ncamera: {width_px: 160, height_px: 120}\nslam: {map: {start: rough}}\n"
    "sessions: [session: {set: []}, session: {set: [world.light.level=0.8, slam.map.start=known]}]\n";

TEST_F(BatchTest, SessionsHaveTheSameBytesHoweverTheyAreMade) {
  write("sessions.yaml", kSessions);
  const std::string run = "run sessions.yaml --seeds 1,2 --out ";
  gaitslam(run + "one");
  gaitslam(run + "two --jobs 2");
  gaitslam("run sessions.yaml --out single --cached");
  expect_same("one", "two");
  expect_same("one/seed-1", "single/seed-1");
  EXPECT_THAT(text_of("one/seed-1/session-2/about.json"), Has("\"world.light.level\": \"sessions.yaml:4\""));

  gaitslam("replay one/seed-1 --out again");
  expect_same("one/seed-1", "again", "recording/");
  gaitslam("replay one/seed-1/session-2 --out alone");
  EXPECT_THAT(differences(folder_ / "one/seed-1/session-2", folder_ / "alone", "recording/"),
              testing::ElementsAre("scenario.yaml"))
      << "it names the map from another folder";

  ok("export one/seed-1 --format orbslam3 --out exported");
  for (const char* session : {"", "/session-1", "/session-2"})
    EXPECT_GT(fs::file_size(folder_ / "exported" / (std::string(".") + session) / "groundtruth.tum"), 500u);

  ended_when("[ -e killed/.seed-2.partial/session-1 ]", "KILL", run + "killed");
  EXPECT_FALSE(fs::exists(folder_ / "killed/seed-2"));
  const auto made = fs::last_write_time(folder_ / "killed/.seed-2.partial/session-1/score.json");
  EXPECT_THAT(gaitslam(run + "killed").out, Has("finished before\n"));
  expect_same("one", "killed");
  EXPECT_EQ(fs::last_write_time(folder_ / "killed/seed-2/session-1/score.json"), made) << "was kept";

  ok("sweep sessions.yaml slam.vision.sigma_px=1 --seeds 1 --out swept");
  EXPECT_THAT(text_of("swept/scores.csv"),
              Has(fmt::format("{}", metric(folder_ / "one/seed-1", "plan_rmse_m"))));
  write("tune.yaml",
        "parameters: {slam.vision.sigma_px: {from: 0.02, to: 0.1, start: 0.04}}\nholdout: [{scenario: "
        "sessions.yaml, seeds: 2}]\n"
        "training: [{scenario: sessions.yaml, seeds: 1}]\nobjective: pose_nll\ntrials: 10\npopulation: 5\n");
  EXPECT_THAT(gaitslam("tune tune.yaml --out tuned").out, Has("0 of 10 trials failed"));
}

TEST_F(BatchTest, AMapThatWasEditedOrIsOfAnotherCameraIsRejectedBeforeTheWalk) {
  ok("run stand.yaml slam.map.save=true --out r");
  shell(
      "cp r/seed-1/map.bin edited.bin && printf 'x' | dd of=edited.bin bs=1 seek=900 conv=notrunc "
      "status=none")
      .ends(0);
  const std::string run = "run stand.yaml --out h slam.map.load=";
  expect_refused({{run + "edited.bin", "edited.bin: edited or truncated: its content differs from the hash"},
                  {run + "none.bin", "none.bin: cannot be read: No such file"},
                  {run + "r/seed-1/map.bin camera.width_px=160 camera.height_px=120",
                   "map.bin: was made with another calibration: 320x240 px"}});
}

// In a container, the program that starts a batch is often process 1.
TEST_F(BatchTest, RunsWhereTheBatchIsTheFirstProcess) {
  if (shell("unshare --user --pid --fork true").exit_code != 0) GTEST_SKIP() << "no namespaces here";
  shell("unshare --user --pid --fork " GAITSLAM_PROGRAM
        " run stand.yaml --without camera,slam --seeds 1,2 --out first")
      .ends(0);
}

TEST_F(BatchTest, CachedRunsHaveTheSameBytesAndShareARecordingAcrossSensorErrorsAndFilters) {
  const std::string run =
                        "run stand.yaml errors.gyro.sigma_rad_s=0.05 errors.accelerometer.sigma_m_s2=0.5 "
                        "slam.vision.sigma_px=3 --out ",
                    fall =
                        "run stand.yaml world.pushes='[{push: {time_s: 0.05, impulse_ns: 300}}]' "
                        "'walk.commands=[{stand: {duration_s: 2}}]' --out ";
  ok("record stand.yaml");
  ok(run + "cached --cached");
  ok(run + "live");
  expect_same("live", "cached");
  const std::string listed = cached();
  EXPECT_EQ(std::ranges::count(listed, '\n'), 1) << "one recording";
  EXPECT_THAT(shell("find 'the cache' -name about.json -exec cat {} +").out,
              AllOf(Has("\"stand.yaml:"), Lacks("/gaitslam-")))
      << "the scenario as given";

  for (const char* out : {"fell", "made --cached", "found --cached"})
    EXPECT_EQ(gaitslam(fall + out).exit_code, 3);
  expect_same("fell", "found");
  EXPECT_THAT(text_of("fell/seed-1/about.json"), Has("fell"));
}

TEST_F(BatchTest, SeedsAreRecordedInParallelAndOnlyIfMissing) {
  EXPECT_THAT(ok("record stand.yaml --seeds 1,2 --jobs 2"), Has("seed 2: recorded, completed"));
  EXPECT_THAT(ok("record stand.yaml --seeds 1..3"), Has("seed 1: was in the cache", "seed 3: recorded"));
  write("suites/ci.yaml",
        "seeds: 1..2\nscenarios: [{scenario: ../stand.yaml, gate: {plan_drift_x_m: {}}}]\n");
  ok("baseline update suites/ci.yaml --reason first --out made --jobs 2");
  EXPECT_THAT(ok("regress suites/ci.yaml --out again --jobs 2 --cached"),
              AllOf(Has("2 seeds paired", "IDENTICAL"), Lacks("SAME")));
  EXPECT_THAT(ok("cache clean"), Has("3 recordings removed"));
  EXPECT_EQ(cached(), "");
  EXPECT_EQ(shell("GAITSLAM_CACHE_GB=much " GAITSLAM_PROGRAM " cache clean").err,
            "gaitslam: GAITSLAM_CACHE_GB is 'much', expected a number of gigabytes\n");
}

TEST_F(BatchTest, ATuningMakesItsRecordingsAndLeavesAnOverlayAndAReportUnlessItIsWorseOnTheHoldout) {
  write("steps.yaml", scenario_of("{straight: {forward_m: 0.1, left_m: 0}}", "rate_hz: 10"));
  const auto write_spec = [&](const std::string& name, const std::string& range, const std::string& holdout) {
    write(
        name,
        "parameters: {" + range +
            "}\n"
            "training: [{scenario: steps.yaml, seeds: 1..2}]\nholdout: [{scenario: steps.yaml, seeds: 3..8" +
            holdout + "}]\ntrials: 8\npopulation: 5\n");
  };
  write_spec("spec.yaml", "slam.vision.sigma_px: {from: 0.1, to: 30, start: 20}", "");
  const Ran first = gaitslam("tune spec.yaml --out first --jobs 2").ends(0);
  EXPECT_THAT(first.out,
              Has("8 settings tried on 2 training runs, 0 of 16 trials failed", "on average over 6 pairs"));
  EXPECT_THAT(text_of("first/tune.json"), Has("\"steps/seed-2\""));
  EXPECT_THAT(text_of("first/report.html"), Has("The search", "pose_nll on hold-out: better, changes by"));
  EXPECT_THAT(ok("config steps.yaml --with first/best.yaml"), Has("best.yaml:3"));
  EXPECT_THAT(ok("record steps.yaml --seeds 1..8"), Lacks(": recorded"));

  write_spec("other.yaml", "slam.gyro.sigma_rad_s: {from: 0.001, to: 0.3, start: 0.1}",
             ", set: [errors.gyro.sigma_rad_s=0.2]");
  expect_refused("tune other.yaml --out first", "first/trials.jsonl: is another log: gaitslam tune spec, ");
  EXPECT_THAT(gaitslam("tune other.yaml --out worse").ends(1).err,
              Has("rejected: pose_nll on hold-out: worse, "));
  EXPECT_FALSE(fs::exists(folder_ / "worse/best.yaml"));
  EXPECT_THAT(text_of("worse/report.html"), Has("<span class='verdict bad'>worse</span>"));
  write("worse/best.yaml", "of another search");
  EXPECT_EQ(gaitslam("tune other.yaml --out worse").exit_code, 1);
  EXPECT_FALSE(fs::exists(folder_ / "worse/best.yaml"));
}

TEST_F(BatchTest, JsonIsOneDocumentAndFilesFollowTheirSchemas) {
  const json run = document_of("run walk.yaml --out r --json", "outcome");
  EXPECT_EQ(run["folder"], "r/seed-1");
  EXPECT_EQ(run["ending"], "completed");
  EXPECT_EQ(run["score"], json_in("r/seed-1/score.json"));
  EXPECT_EQ(document_of("replay r/seed-1 --json", "outcome")["score"], run["score"]);
  EXPECT_GT(document_of("score r/seed-1 --json", "trajectory")["errors"].size(), 2u);
  const json seeds = document_of("run stand.yaml estimator=plan_alone --seeds 1,2 --out s --json", "outcome");
  EXPECT_EQ(seeds["summary"], json_in("s/summary.json"));
  for (const auto& [schema, file] : {std::pair{"score", "s/seed-1/score.json"},
                                     {"about", "s/seed-1/about.json"},
                                     {"summary", "s/summary.json"},
                                     {"score", "r/seed-1/score.json"}})
    EXPECT_EQ(checked(schema, file).exit_code, 0) << file;
  write("wrong.json", R"({"format_version": 1, "scenario": 7})");
  EXPECT_NE(checked("score", "wrong.json").exit_code, 0);
}

TEST_F(BatchTest, QuietKeepsTheExitCode) {
  for (const auto& [arguments, exit_code] :
       {std::pair{"run stand.yaml limits.rmse_m.at_most=0 --out r -q", 1},
        {"replay r/seed-1 --quiet --scenario stand.yaml", 0},
        {"score r/seed-1 -q", 0},
        {"run stand.yaml limits.rmse_m.at_most=0 --seeds 1 --out s -q", 1}}) {
    const Ran ran = gaitslam(arguments).ends(exit_code);
    EXPECT_EQ(ran.out + ran.err, "") << arguments;
  }
  expect_refused("run none.yaml -q", "none.yaml: cannot be read");
  expect_refused("run walk.yaml -q --json", "excludes");
}

TEST_F(BatchTest, AFilterThatSeesNothingIsLostToTheEndAndOneThatSeesAgainTracksAgain) {
  short_walks("r");
  write("times.yaml",
        "slam.tracking: {lost_after_s: 0.4, give_up_s: 0.6}\n"
        "limits: {ending: [completed], tracked_fraction: {at_least: 0.99}}\n");
  const auto without_images = [&](const std::string& time, int exit_code, const std::string& printed) {
    const Ran ran =
        gaitslam("replay r/seed-1 --with times.yaml --out out --force 'errors.faults=[{frames_lost: {" +
                 time + "}}]'");
    EXPECT_EQ(ran.exit_code, exit_code) << ran.out << ran.err;
    EXPECT_THAT(ran.out, Has(printed));
    return json_in("out/score.json");
  };
  const std::string cause = "tracking lost: no image arrives";
  const json never = without_images("duration_s: 100", 3, "to the end: " + cause),
             lost = never["tracking"]["lost"];
  EXPECT_EQ(never["ending"], "diverged");
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0]["cause"], cause);
  EXPECT_TRUE(lost[0]["to_s"].is_null());
  EXPECT_LT(never["metrics"]["tracked_fraction"]["value"], 0.5);
  EXPECT_THAT(text_of("out/frames.csv"), Has(",lost," + cause + ","));

  const json again = without_images("from_s: 0.5, duration_s: 0.6", 1, ">= 0.9900  MISSED"),
             for_a_time = again["tracking"]["lost"];
  EXPECT_EQ(again["ending"], "completed");
  ASSERT_EQ(for_a_time.size(), 1U);
  EXPECT_NEAR(for_a_time[0]["from_s"], 0.9, 0.04);  // 0.4 s after the last image, within a frame
  EXPECT_NEAR(for_a_time[0]["to_s"], 1.1, 0.04);

  EXPECT_TRUE(never["metrics"]["rmse_m"]["value"].is_null());
}

class SweepTest : public CommandLine {
 protected:
  std::vector<json> lines(const std::string& file) const {
    std::vector<json> all;
    for (const std::string& line : sim::files::lines_of(text_of(file))) all.push_back(json::parse(line));
    return all;
  }
};
using LongSweepTest = SweepTest;

TEST_F(SweepTest, AnnouncesWhatItWouldTryAndSimulate) {
  write("walk.yaml", kStand);
  EXPECT_THAT(
      ok("sweep walk.yaml slam.vision.sigma_px=1,2 world.seed=1,2,3 --seeds 1,2 --dry-run"),
      Has("12 trials = 6 configurations x 2 seeds, on 6 recordings: 0 in the cache, 6 to be simulated",
          "walk slam.vision.sigma_px=2 world.seed=3\n"));
  EXPECT_FALSE(fs::exists(folder_ / "results"));
  ok("record walk.yaml --seeds 1,2");
  EXPECT_THAT(ok("sweep walk.yaml world.seed=1,2 --seeds 1,2 --dry-run"),
              Has("on 4 recordings: 2 in the cache, 2 to be simulated"));
}

TEST_F(SweepTest, ScoresMatchThoseOfRunsBitForBitForAnyNumberOfJobs) {
  const std::string sweep =
      "sweep walk.yaml slam.vision.sigma_px=1,3 errors.gyro.sigma_rad_s=0.01,0.05 "
      "errors.image.loss_fraction=0.1 --seeds 2 --out ";
  ok(sweep + "sweep");
  ok(sweep + "two --jobs 2");
  for (const std::string file : {"/scores.csv", "/scores.jsonl", "/trials.jsonl"}) {
    EXPECT_FALSE(text_of("sweep" + file).empty());
    EXPECT_EQ(text_of("sweep" + file), text_of("two" + file)) << file;
  }
  EXPECT_THAT(text_of("sweep/scores.csv"),
              StartsWith("trial,scenario,seed,slam.vision.sigma_px,errors.gyro.sigma_rad_s,"
                         "errors.image.loss_fraction,ending,cause,"));
  const std::vector<json> scores = lines("sweep/scores.jsonl");
  ASSERT_EQ(scores.size(), 4u);
  EXPECT_NE(scores[0]["values"]["rmse_m"], scores[3]["values"]["rmse_m"]);
  ok("run walk.yaml seed=2 slam.vision.sigma_px=3 errors.gyro.sigma_rad_s=0.05 "
     "errors.image.loss_fraction=0.1 --out run");
  const json run = json_in("run/seed-2/score.json");
  EXPECT_EQ(scores[3]["ending"], run["ending"]);
  const json& values = scores[3]["values"];
  EXPECT_GT(values.size(), 20u);
  for (const auto& [name, metric] : run["metrics"].items())
    EXPECT_EQ(values.contains(name) ? values[name] : json(), metric["value"]) << name;
}

TEST_F(SweepTest, TrialsWithOtherEstimatorFilesAreNotReused) {
  fs::copy(kSources + "/tools/examples/gyro_and_plan.py", folder_ / "gyro.py");
  write("walk.yaml", kStand + "estimator: {program: [/usr/bin/python3, gyro.py]}\n");
  const std::string sweep = "sweep walk.yaml errors.gyro.sigma_rad_s=0.01,0.02 --out s";
  ok(sweep);
  shell("sed -i -E 's/(\"values\":\\{\"[a-z_0-9]+\":)[0-9.e-]+/\\142/' s/trials.jsonl");
  EXPECT_THAT(ok(sweep), Has("2 trials finished before"));
  EXPECT_EQ(*lines("s/scores.jsonl")[1]["values"].begin(), 42) << "it was taken from the log";
  shell("echo '# changed' >> gyro.py");
  EXPECT_THAT(
      gaitslam(sweep).ends(2).err,
      Has("s/trials.jsonl: belongs to another sweep, or was made with other scenarios, another program "
          "or other estimator files; --force starts over"));
  EXPECT_THAT(gaitslam("sweep walk.yaml errors.gyro.sigma_rad_s=0.03 --out s").ends(2).err,
              Has("belongs to another sweep"));
  EXPECT_THAT(ok(sweep + " --force"), Lacks("finished before"));
  write("full/file", "x");
  EXPECT_EQ(gaitslam("sweep walk.yaml --out full").exit_code, 2);
}

// The log marks the scores of trials that were finished earlier.
TEST_F(SweepTest, WithForceItContinuesWhereTheSameSweepWasInterrupted) {
  const std::string sweep = "sweep walk.yaml 'slam.vision.sigma_px={from: 1, to: 3, points: 30}' --out s ";
  ok("sweep walk.yaml slam.vision.sigma_px=4 --out s");
  const std::string old = text_of("s/scores.csv"), old_lines = text_of("s/scores.jsonl");
  ended_when("[ \"$(cat s/trials.jsonl | wc -l)\" -ge 5 ]", "KILL", sweep + "--force");
  EXPECT_EQ(text_of("s/scores.csv"), old) << "the new ones are not whole";
  EXPECT_EQ(text_of("s/scores.jsonl"), old_lines);
  shell("sleep 0.2; sed -i 's/\"rmse_m\":[0-9.e-]*/\"rmse_m\":42/' s/trials.jsonl");
  const auto taken_from_the_log = [&] {
    ok(sweep + "--force");
    const std::vector<json> scores = lines("s/scores.jsonl");
    EXPECT_EQ(scores.size(), 30u);
    return std::ranges::count_if(scores, [](const json& score) { return score["values"]["rmse_m"] == 42; });
  };
  EXPECT_GE(taken_from_the_log(), 3);
  EXPECT_EQ(taken_from_the_log(), 0) << "it was finished: everything is done again";
}

// The limit of one second kills the simulation of the long walk; the walk with the long step cannot be
// planned.
TEST_F(SweepTest, ATrialThatKillsItsProcessOrCannotBeSimulatedIsLoggedAndTheOthersContinue) {
  ok("record walk.yaml");
  const Ran ran =
      shell("ulimit -t 1; " GAITSLAM_PROGRAM
            " sweep walk.yaml 'walk.commands=[{stand: {duration_s: 30}}],[{steps: [{forward_m: 0.9, left_m: "
            "0.19}]}],[{stand: {duration_s: 0.3}}, {straight: {forward_m: 0.15}}]' --out sweep")
          .ends(3);
  EXPECT_THAT(ran.err,
              Has("1 of 3 trials crashed: killed by signal 9 (Killed)", "1 of 3 trials not started: "));
  const auto scores = lines("sweep/scores.jsonl");
  ASSERT_EQ(scores.size(), 3u);
  EXPECT_EQ(scores[0]["ending"], "crashed");
  EXPECT_EQ(scores[1]["ending"], "not started");
  EXPECT_NE(scores[1]["cause"], "");
  EXPECT_EQ(scores[2]["ending"], "completed");
}

// The trials have the values of runs with the same settings, unlike replays of a single recording.
TEST_F(LongSweepTest, ATuningSimulatesAWalkSteeredByItsEstimateAnewForEachSetting) {
  write("steered.yaml",
        "walk: {commands: [{straight: {forward_m: 0.2, left_m: 0}}], steering: {by: estimate, final_steps: "
        "0}}\ncamera: {rate_hz: 10}\nslam: {}\n");
  write("spec.yaml",
        "parameters: {slam.leg_odometry.sigma_m_s: {from: 0.001, to: 10, start: 1}}\n"
        "training: [{scenario: steered.yaml, seeds: 1}]\nholdout: [{scenario: steered.yaml, seeds: 2}]\n"
        "trials: 6\npopulation: 5\n");
  const Ran ran = gaitslam("tune spec.yaml --jobs 2 --out tuned");
  ASSERT_LE(ran.exit_code, 1) << ran.err;  // 1: worse on the hold-out
  EXPECT_THAT(ran.out, Has("each setting is simulated"));
  std::set<double> tried;
  for (const std::string& line : sim::files::lines_of(text_of("tuned/trials.jsonl")))
    if (line.starts_with('{') && json::parse(line)["seed"] == 1)
      tried.insert(json::parse(line)["values"]["navigation_rmse_m"].get<double>());
  EXPECT_GT(tried.size(), 1U) << "the setting has no influence on this walk";
  const std::string last = shell("tail -n 1 tuned/history.csv | cut -d, -f3 | tr -d '\n'").out;
  ASSERT_LE(gaitslam("run steered.yaml slam.leg_odometry.sigma_m_s=" + last + " --out run").exit_code, 1);
  const json run = json_in("run/seed-1/score.json");
  EXPECT_TRUE(tried.contains(run["metrics"]["navigation_rmse_m"]["value"].get<double>())) << last;
}

class Interruption : public CommandLine {
 protected:
  Interruption() { write("stand.yaml", kStand + "name: walk\n"); }

  /// Partial files and folders below a folder.
  std::vector<std::string> partial(const std::string& folder) const {
    std::vector<std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / folder))
      if (entry.path().filename().string().find(".partial") != std::string::npos) all.push_back(entry.path());
    return all;
  }
};

TEST_F(Interruption, ASeedThatCrashesHasNoScoreThoughAnOlderResultStays) {
  ok(kBlindStand + "--seeds 1,2 --out h");
  const Ran ran = shell("ulimit -t 2; " GAITSLAM_PROGRAM " " + kBlindStand +
                        "'walk.commands=[{stand: {duration_s: 300}}]' --seeds 1,2 --out h --force")
                      .ends(3);
  EXPECT_THAT(ran.err, Has("seeds 1, 2: killed by signal"));
  EXPECT_EQ(ran.err.find("killed"), ran.err.rfind("killed")) << "a message that seeds share appears once";
  EXPECT_THAT(ran.out, ContainsRegex("failed +crashed +seeds 1, 2"));
  EXPECT_THAT(text_of("h/summary.json"), Has("\"ending\": \"crashed\""));
  EXPECT_TRUE(fs::exists(folder_ / "h/seed-1/score.json"));
}

TEST_F(Interruption, SeedsAreAddedOnlyToThoseWithTheSameSettings) {
  const auto seeds = [&] { return json_in("h/summary.json")["seeds"].size(); };
  ok(kBlindStand + "seed=1 --out h");
  ok(kBlindStand + "seed=2 --out h");
  EXPECT_THAT(ok(kBlindStand + "--seeds 1..3 --out h"),
              Has("2 results finished before\n", "walk, 3 seeds\n"));
  EXPECT_THAT(ok(kBlindStand + "--seeds 4 --out h"), Has("walk, 4 seeds\n"));
  EXPECT_EQ(seeds(), 4u);
  ok(kBlindStand + "seed=7 --out h");
  EXPECT_EQ(seeds(), 5u) << "a single run renews the summary";
  expect_refused(kBlindStand + "seed=7 --out h", "h/seed-7: already exists; --force replaces it");

  for (const char* name : {"seed-07", "seed-+3", "seed-x"})  // names that the program does not use
    write(std::string("h/") + name + "/score.json", "{}");
  const std::string slippery = kBlindStand + "world.floor_friction=0.2 ";
  for (const char* other : {"--seeds 8", "seed=8"})
    expect_refused(
        slippery + other + " --out h",
        "h/seed-1: exists, but world.floor_friction is 0.15 there and 0.2 here; --force replaces it, "
        "--out names another folder");
  ok(slippery + "seed=8 --out h --force");
  EXPECT_EQ(seeds(), 1u) << "seeds with the same settings";
  EXPECT_THAT(ok(slippery + "--seeds 2,9 --out h --force"), Has("walk, 3 seeds\n"));
  EXPECT_THAT(text_of("h/seed-1/scenario.yaml"), Lacks("floor_friction: 0.2")) << "it was not named";
}

TEST_F(Interruption, KilledSeedsAreResumedByTheSameCommand) {
  const std::string run = kBlind + "--seeds 1..4 --out ";
  ok(run + "whole");
  ended_when("[ -e killed/.seed-1.partial ]", "KILL", run + "killed");
  ended_when("[ -e killed/seed-2 ]", "KILL", run + "killed");
  const auto made = fs::last_write_time(folder_ / "killed/seed-1/score.json");
  EXPECT_THAT(ok(run + "killed --force"), Has("finished before\n")) << "also with --force";
  EXPECT_EQ(fs::last_write_time(folder_ / "killed/seed-1/score.json"), made) << "it was whole";
  EXPECT_THAT(differences(folder_ / "whole", folder_ / "killed"), IsEmpty());
  EXPECT_THAT(partial("killed"), IsEmpty());
}

// The estimator appends to the file `ran`.
TEST_F(Interruption, ResultsOfExternalProgramsAreMadeAgainByForceAndKeptOnlyIfTheProgramIsTheSame) {
  fs::copy(kSources + "/tools/examples/gyro_and_plan.py", folder_ / "gyro.py");
  const std::string run =
      "run walk.yaml 'estimator={program: [/usr/bin/python3, gyro.py]}' --seeds 1,2 --out h ";
  ok(run);
  shell("echo 'open(\"ran\", \"a\").write(\"x\")' | cat - gyro.py > new && mv new gyro.py");
  expect_refused(run, "h/seed-1: exists, but its programs' hash is ");
  for (const char* times : {"xx", "xxxx"}) {
    EXPECT_THAT(ok(run + "--force"), Lacks("finished before"));
    EXPECT_EQ(text_of("ran"), times);
  }
  EXPECT_THAT(ok(run), Has("2 results finished before"));
}

TEST_F(Interruption, OnlyLeftoversInTheTemporaryFolderAreRemovedAtTheNextStart) {
  ok(kBlindStand + "--seeds 1,2 --out tmp/gaitslam-result");
  write("tmp/gaitslam-letter/dear.txt", "mine");
  ::setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
  const std::string run = kBlind + "--seeds 1,2 --out ";
  ended_when("[ -e h/.seed-1.partial ]", "KILL", run + "h");
  EXPECT_GT(std::distance(fs::directory_iterator(folder_ / "tmp"), {}), 2);
  ok(run + "again");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "tmp"), {}), 2);
  EXPECT_EQ(text_of("tmp/gaitslam-letter/dear.txt"), "mine");
  EXPECT_TRUE(fs::exists(folder_ / "tmp/gaitslam-result/seed-1/score.json"));
  ::setenv("TMPDIR", "/no such folder", 1);
  EXPECT_EQ(refusal(run + "none"),
            "gaitslam: TMPDIR: /no such folder: is not a folder, expected one for temporary files\n");
  ::unsetenv("TMPDIR");
}

constexpr const char* kLong = "run walk.yaml 'walk.commands=[{stand: {duration_s: 300}}]' ";

TEST_F(Interruption, TheSecondOfTwoCommandsOnOneFolderIsRefused) {
  const Ran ran = shell(GAITSLAM_PROGRAM " " + std::string(kLong) +
                        "--seeds 1,2 --out h --without camera,slam & first=$!; until [ -e h/.seed-1.partial "
                        "]; do sleep 0.02; done; " GAITSLAM_PROGRAM " " +
                        kBlind + "--seeds 1,2 --out h --force; code=$?; kill -9 $first; exit $code");
  EXPECT_EQ(ran.exit_code, 2);
  EXPECT_THAT(ran.err, Has("h: another process is writing there; wait for it, or choose another folder"));
}

TEST_F(Interruption, ReportsWhatIsKept) {
  const std::string seeds = kBlind + "--seeds 1..50 --out h";
  EXPECT_THAT(
      ended_when("[ -e h/.seed-1.partial ]", "INT", seeds).err,
      Has("gaitslam: interrupted: finished results are kept in h; to resume:\n  " GAITSLAM_PROGRAM " " +
          seeds + "\n"));
  const Ran one = ended_when("[ -e k/.seed-1.partial ]", "INT", std::string(kLong) + "--out k");
  EXPECT_THAT(one.err, Has("gaitslam: interrupted: this run leaves no result; earlier results in k are"));
  EXPECT_EQ(one.exit_code, 130);
  EXPECT_THAT(ended_when("[ -e s/trials.jsonl ]", "TERM",
                         "sweep walk.yaml 'slam.vision.sigma_px={from: 1, to: 3, points: 50}' --out s")
                  .err,
              Has("finished results are kept in s; to resume"));
}

class OwnFiles : public CommandLine {
 protected:
  OwnFiles() { write("walk.yaml", kStand); }
  void run(const std::string& arguments) const { ok("run walk.yaml " + arguments); }
  /// Expects that the command is rejected with this message and changes no file of the folder.
  void expect_spared(const std::string& arguments, const std::string& folder,
                     const std::string& named) const {
    const auto before = files(folder_ / folder);
    EXPECT_THAT(refusal(arguments), Has(named)) << arguments;
    EXPECT_THAT(differences(before, files(folder_ / folder)), IsEmpty()) << arguments;
  }
};

TEST_F(OwnFiles, ForceReplacesNoFolderAndNoFileOfTheUser) {
  run("--out one");
  write("home/letter.txt", "dear");
  for (const char* name : {"summary.json", "trials.jsonl", "scores.csv"})
    write(std::string("home/") + name, "mine");
  write("home/seed-1/diary.txt", "mine");
  fs::create_directory_symlink(folder_ / "home", folder_ / "link");
  for (const auto& [command, named] : std::vector<std::pair<std::string, std::string>>{
           {"replay one/seed-1 --out home", "home: was not created by gaitslam"},
           {"export one/seed-1 --format tum --out home", "home: was not created by gaitslam"},
           {"report one/seed-1 --plots svg --out home", "home: was not created by gaitslam"},
           {"replay one/seed-1 --out link", "link: is a symbolic link"},
           {kBlind + "--seeds 2,3 --out home", "home: was not created by gaitslam"},
           {kBlind + "--out home", "home: was not created by gaitslam"}})
    expect_spared(command + " --force", "home", named);
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_THAT(gaitslam("sweep walk.yaml slam.vision.sigma_px=1,2 --out home --force").ends(2).err,
              Has("home: was not created by gaitslam"));
}

TEST_F(OwnFiles, VerdictsReplaceOnlyThoseOfAnEarlierCall) {
  run("--without camera,slam --out one");
  for (const std::string option : {"--json", "--junit", "--markdown"}) {
    const std::string compare = "compare one/seed-1 one/seed-1 " + option + " verdicts";
    ok(compare);
    const std::string verdicts = text_of("verdicts");
    for (const std::string& replaced : {std::string(), verdicts}) {
      write("verdicts", replaced);
      ok(compare);
      EXPECT_EQ(text_of("verdicts"), verdicts);
    }
    write("verdicts", "### my notes");
    expect_refused(compare, "verdicts: exists and was not written by gaitslam");
    EXPECT_EQ(text_of("verdicts"), "### my notes");
    fs::remove(folder_ / "verdicts");
  }
}

TEST_F(OwnFiles, NeitherInputsNorTheCurrentFolderAreReplaced) {
  run("--out one");
  for (const std::string command : {"replay one/seed-1 --out one/seed-1 --force",
                                    "report one/seed-1 --plots svg --out one/seed-1 --force"})
    expect_spared(command, "one", "would be replaced, but the command reads one/seed-1");
  for (const std::string command : {"replay ../one/seed-1", "report ../one/seed-1 --plots svg --force"})
    for (const std::string out : {".", "\"$PWD\"", "../here"}) {
      const Ran ran =
          shell("rm -rf here; mkdir here; cd here; " GAITSLAM_PROGRAM " " + command + " --out " + out);
      EXPECT_EQ(ran.exit_code, 2) << command << out;
      EXPECT_THAT(ran.err, Has(": would be replaced, but is or contains the current folder"));
      EXPECT_TRUE(fs::is_empty(folder_ / "here"));
    }
}

}  // namespace
}  // namespace tests
