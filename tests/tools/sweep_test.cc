// Sweeps: announced trials, scores of replays, and the same bytes for any number of jobs and after being
// killed.
#include "tests/tools/command_line.h"

namespace tests {
namespace {

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
    return std::count_if(scores.begin(), scores.end(),
                         [](const json& score) { return score["values"]["rmse_m"] == 42; });
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

}  // namespace
}  // namespace tests
