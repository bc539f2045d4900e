// Runs, replays and recordings through the program: the same bytes for any number of processes and from the
// cache of recordings; output as text, as one JSON document, or none; and a filter that cannot see.
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
  std::string cached() const { return ok("cache list"); }
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
  ok(replay + "again");
  expect_same("results/walk/seed-1", "again", "recording/");
  expect_refused(replay + "again", "again: already exists; --force replaces it");
  ok(replay + "again --force");

  write("loud.yaml", kShortWalk + "errors: {gyro: {sigma_rad_s: 0.02}}\nname: walk\n");
  ok(replay + "same --scenario walk.yaml");
  ok(replay + "loud --scenario loud.yaml");
  EXPECT_EQ(text_of("same/estimate.tum"), text_of("again/estimate.tum"));
  EXPECT_NE(text_of("loud/estimate.tum"), text_of("same/estimate.tum"));
  write("other.yaml", scenario_of("{stand: {duration_s: 2}}"));
  const Ran other = gaitslam(replay + "other --scenario other.yaml").ends(2);
  EXPECT_THAT(other.err, Has("other.yaml: walk.commands is"));
}

// In a container the program that starts a batch is often process 1.
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
  EXPECT_THAT(listed, Has("stand seed 1"));
  EXPECT_EQ(std::count(listed.begin(), listed.end(), '\n'), 2) << "one recording and the sum";
  EXPECT_THAT(shell("find 'the cache' -name about.json -exec cat {} +").out,
              AllOf(Has("\"stand.yaml:"), Lacks("/gaitslam-")))
      << "the scenario as given";

  for (const char* out : {"fell", "made --cached", "found --cached"})
    EXPECT_EQ(gaitslam(fall + out).exit_code, 3);
  expect_same("fell", "made");
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
  EXPECT_THAT(cached(), Lacks("seed"));
  EXPECT_EQ(shell("GAITSLAM_CACHE_GB=much " GAITSLAM_PROGRAM " cache list").err,
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
  write("strict.yaml", "base: walk.yaml\nlimits: {rmse_m: {at_most: 0}}\n");
  for (const auto& [arguments, exit_code] : {std::pair{"run walk.yaml --out r -q", 0},
                                             {"replay r/seed-1 --quiet", 0},
                                             {"score r/seed-1 -q", 0},
                                             {"run strict.yaml --seeds 1 --out s -q", 1}}) {
    const Ran ran = gaitslam(arguments).ends(exit_code);
    EXPECT_EQ(ran.out + ran.err, "") << arguments;
  }
  expect_refused("run none.yaml -q", "none.yaml: cannot be read");
  expect_refused("run walk.yaml -q --json", "excludes");
}

TEST_F(BatchTest, AFilterThatSeesNothingDivergesAndOneThatSeesAgainTracksAgain) {
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
  const std::string whole = "tracking lost: no image arrives; the map was not found again";
  const json never = without_images("duration_s: 100", 3, "to the end: " + whole),
             lost = never["tracking"]["lost"];
  EXPECT_EQ(never["ending"], "diverged");
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0]["cause"], whole);
  EXPECT_TRUE(lost[0]["to_s"].is_null());
  EXPECT_LT(never["metrics"]["tracked_fraction"]["value"], 0.5);
  EXPECT_THAT(text_of("out/frames.csv"),
              Has(",lost,tracking lost: no image arrives,", ",diverged," + whole + ","));

  const json again = without_images("from_s: 0.5, duration_s: 0.6", 1, ">= 0.9900  MISSED"),
             for_a_time = again["tracking"]["lost"];
  EXPECT_EQ(again["ending"], "completed");
  ASSERT_EQ(for_a_time.size(), 1U);
  EXPECT_NEAR(for_a_time[0]["from_s"], 0.9, 0.04);  // 0.4 s after the last image, within a frame
  EXPECT_NEAR(for_a_time[0]["to_s"], 1.1, 0.04);

  const json at_last =
      without_images("from_s: 4.5, duration_s: 100", 3, "to the end: tracking lost: no image");
  EXPECT_EQ(at_last["ending"], "diverged");
  EXPECT_TRUE(at_last["metrics"]["rmse_m"]["value"].is_number()) << "of the poses before";
  EXPECT_TRUE(never["metrics"]["rmse_m"]["value"].is_null());
}

}  // namespace
}  // namespace tests
