// Sweeps: announced trials, scores of replays, and the same bytes for any number of jobs and after kills.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/tools/command_line.h"

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using tests::Ran;

class SweepTest : public tests::CommandLineWithCache {
 protected:
  SweepTest() { write("walk.yaml", tests::kShortWalk); }

  std::vector<json> lines(const std::string& file) const {
    std::vector<json> all;
    std::istringstream text(text_of(file));
    for (std::string line; std::getline(text, line);) all.push_back(json::parse(line));
    return all;
  }
  void expect_same_scores(const std::string& a, const std::string& b) const {
    for (const char* file : {"/scores.csv", "/scores.jsonl", "/trials.jsonl"}) {
      EXPECT_FALSE(text_of(a + file).empty());
      EXPECT_EQ(text_of(a + file), text_of(b + file)) << a << " and " << b << file;
    }
  }
};
using LongSweepTest = SweepTest;

TEST_F(SweepTest, SaysWhatItWouldTryAndSimulate) {
  write("walk.yaml", tests::kStand);
  const Ran dry = gaitslam("sweep walk.yaml slam.vision.sigma_px=1,2 world.seed=1,2,3 --seeds 1,2 --dry-run");
  EXPECT_EQ(dry.exit_code, 0) << dry.err;
  EXPECT_THAT(dry.out,
              HasSubstr("12 trials = 6 configurations x 2 seeds, on 6 recordings: 0 in the cache, 6 to be "
                        "simulated"));
  EXPECT_THAT(dry.out, HasSubstr("walk slam.vision.sigma_px=2 world.seed=3\n"));
  EXPECT_FALSE(fs::exists(folder_ / "results"));
  ASSERT_EQ(gaitslam("record walk.yaml --seeds 1,2").exit_code, 0);
  EXPECT_THAT(gaitslam("sweep walk.yaml world.seed=1,2 --seeds 1,2 --dry-run").out,
              HasSubstr("on 4 recordings: 2 in the cache, 2 to be simulated"));
}

TEST_F(SweepTest, ScoresAreThoseOfRunsBitForBitForAnyNumberOfJobs) {
  const std::string keys[]{"slam.vision.sigma_px=1 errors.gyro.sigma_rad_s=0.01",
                           "slam.vision.sigma_px=3 errors.gyro.sigma_rad_s=0.05"};
  const std::string sweep =
      "sweep walk.yaml slam.vision.sigma_px=1,3 errors.gyro.sigma_rad_s=0.01,0.05 --seeds 2 ";
  const Ran swept = gaitslam(sweep + "--out sweep");
  ASSERT_EQ(swept.exit_code, 0) << swept.err;
  ASSERT_EQ(gaitslam(sweep + "--jobs 2 --out two").exit_code, 0);
  expect_same_scores("sweep", "two");
  const std::vector<json> scores = lines("sweep/scores.jsonl");
  ASSERT_EQ(scores.size(), 4u);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string out = "run" + std::to_string(i);
    ASSERT_EQ(gaitslam("run walk.yaml seed=2 " + keys[i] + " --out " + out).exit_code, 0);
    const json run = json::parse(text_of(out + "/seed-2/score.json")), &score = scores[3 * i];
    EXPECT_EQ(score["ending"], run["ending"]);
    int compared = 0;
    for (const auto& [name, metric] : run["metrics"].items()) {
      EXPECT_EQ(score["values"].contains(name), !metric["value"].is_null()) << name;
      if (metric["value"].is_null()) continue;
      EXPECT_EQ(score["values"][name].get<double>(), metric["value"].get<double>()) << name;
      ++compared;
    }
    EXPECT_GT(compared, 20);
  }
  EXPECT_NE(scores[0]["values"]["rmse_m"], scores[3]["values"]["rmse_m"]);
  EXPECT_THAT(text_of("sweep/scores.csv"),
              StartsWith("trial,scenario,seed,slam.vision.sigma_px,errors.gyro.sigma_rad_s,ending,cause,"));
}

TEST_F(SweepTest, TrialsOfOtherFilesOfTheEstimatorDoNotCountAsItsOwn) {
  fs::copy(std::string(GAITSLAM_SOURCE_DIR) + "/tools/examples/gyro_and_plan.py", folder_ / "gyro.py");
  write("walk.yaml", std::string(tests::kStand) + "estimator: {program: [/usr/bin/python3, gyro.py]}\n");
  const std::string sweep = "sweep walk.yaml errors.gyro.sigma_rad_s=0.01,0.02 --out s";
  ASSERT_EQ(gaitslam(sweep).exit_code, 0);
  shell("sed -i -E 's/(\"values\":\\{\"[a-z_0-9]+\":)[0-9.e-]+/\\142/' s/trials.jsonl");
  EXPECT_THAT(gaitslam(sweep).out, HasSubstr("2 trials finished before"));
  EXPECT_EQ(*lines("s/scores.jsonl")[1]["values"].begin(), 42) << "it was taken from the log";
  shell("echo '# changed' >> gyro.py");
  const Ran other = gaitslam(sweep);
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err,
              HasSubstr("s/trials.jsonl: belongs to another sweep, other scenarios, another program or "
                        "other files of the estimator; --force starts again"));
  EXPECT_THAT(gaitslam(sweep + " --force").out, Not(HasSubstr("finished before")));
}

// The log marks scores of trials that were finished earlier.
TEST_F(SweepTest, ByForceItGoesOnWhereTheSameWasInterrupted) {
  const std::string sweep = "sweep walk.yaml 'slam.vision.sigma_px={from: 1, to: 3, points: 30}' --out s ";
  ASSERT_EQ(gaitslam("sweep walk.yaml slam.vision.sigma_px=4 --out s").exit_code, 0);
  const std::string old = text_of("s/scores.csv"), old_lines = text_of("s/scores.jsonl");
  shell(GAITSLAM_PROGRAM " " + sweep +
        "--force & sweep=$!; while kill -0 $sweep && [ \"$(cat s/parts/*.log | wc -l)\" -lt 4 ]; do sleep "
        "0.02; done; kill -9 $sweep; wait $sweep");
  EXPECT_EQ(text_of("s/scores.csv"), old) << "the new ones are not whole";
  EXPECT_EQ(text_of("s/scores.jsonl"), old_lines);
  const Ran marked = shell("sleep 0.2; sed -i 's/\"rmse_m\":[0-9.e-]*/\"rmse_m\":42/' s/parts/*.log");
  ASSERT_EQ(marked.exit_code, 0) << marked.err;
  const auto taken_from_the_log = [&] {
    const std::vector<json> scores = lines("s/scores.jsonl");
    EXPECT_EQ(scores.size(), 30u);
    return std::count_if(scores.begin(), scores.end(),
                         [](const json& score) { return score["values"]["rmse_m"] == 42; });
  };
  ASSERT_EQ(gaitslam(sweep + "--force").exit_code, 0);
  EXPECT_GE(taken_from_the_log(), 3);
  ASSERT_EQ(gaitslam(sweep + "--force").exit_code, 0);
  EXPECT_EQ(taken_from_the_log(), 0) << "it was finished: all is done again";
}

// The limit of one second kills the simulation of the long walk.
TEST_F(SweepTest, ATrialThatKillsItsProcessEachTimeIsLoggedAndTheOthersGoOn) {
  ASSERT_EQ(gaitslam("record walk.yaml").exit_code, 0);
  const Ran ran = shell("ulimit -t 1; " GAITSLAM_PROGRAM
                        " sweep walk.yaml 'walk.commands=[{stand: {duration_s: 30}}],[{stand: {duration_s: "
                        "0.3}}, {straight: {forward_m: 0.15}}]' --out sweep");
  EXPECT_EQ(ran.exit_code, 3);
  EXPECT_THAT(ran.err, HasSubstr("1 of 2 trials crashed: killed by signal 9 (Killed)"));
  const auto scores = lines("sweep/scores.jsonl");
  ASSERT_EQ(scores.size(), 2u);
  EXPECT_EQ(scores[0]["ending"], "crashed");
  EXPECT_EQ(scores[1]["ending"], "completed");
}

TEST_F(SweepTest, AWalkThatCannotBeSimulatedIsToldWithItsCause) {
  const Ran ran = gaitslam(
      "sweep walk.yaml walk.step_length_m=0.4 'walk.commands=[{stand: {duration_s: 1}}],[{straight: "
      "{forward_m: 2}}]' --out sweep");
  EXPECT_EQ(ran.exit_code, 3) << ran.out << ran.err;
  const auto scores = lines("sweep/scores.jsonl");
  ASSERT_EQ(scores.size(), 2u);
  EXPECT_EQ(scores[0]["ending"], "completed");
  EXPECT_EQ(scores[1]["ending"], "not started");
  EXPECT_FALSE(scores[1]["cause"].get<std::string>().empty());
  EXPECT_THAT(ran.err, HasSubstr("1 of 2 trials not started: "));
}

TEST_F(SweepTest, AnotherSweepsFolderIsRefused) {
  write("walk.yaml", tests::kStand);
  ASSERT_EQ(gaitslam("sweep walk.yaml slam.vision.sigma_px=1 --out sweep").exit_code, 0);
  const Ran other = gaitslam("sweep walk.yaml slam.vision.sigma_px=2 --out sweep");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("belongs to another sweep"));
  EXPECT_EQ(gaitslam("sweep walk.yaml slam.vision.sigma_px=2 --out sweep --force").exit_code, 0);
  EXPECT_EQ(lines("sweep/scores.jsonl")[0]["settings"]["slam.vision.sigma_px"], 2);
  write("full/file", "x");
  EXPECT_EQ(gaitslam("sweep walk.yaml --out full").exit_code, 2);
}

// The trials have the values of runs with the same settings; replays of one recording would not.
TEST_F(LongSweepTest, ATuningSimulatesAWalkThatItsEstimateSteersWithEachSetting) {
  write("steered.yaml",
        "walk: {commands: [{straight: {forward_m: 0.2, left_m: 0}}], steering: {by: estimate, final_steps: "
        "0}}\n"
        "camera: {rate_hz: 10}\nslam: {}\n");
  write("spec.yaml",
        "parameters: {slam.vision.sigma_px: {from: 0.05, to: 20, start: 1}}\n"
        "training: [{scenario: steered.yaml, seeds: 1}]\nholdout: [{scenario: steered.yaml, seeds: 2}]\n"
        "trials: 6\npopulation: 5\n");
  const Ran ran = gaitslam("tune spec.yaml --jobs 2 --out tuned");
  ASSERT_LE(ran.exit_code, 1) << ran.err;  // 1: worse on the hold-out
  EXPECT_THAT(ran.out, HasSubstr("each setting is simulated"));
  std::istringstream log(text_of("tuned/trials.jsonl"));
  std::set<double> tried;
  for (std::string line; std::getline(log, line);)
    if (line.starts_with('{') && json::parse(line)["seed"] == 1)
      tried.insert(json::parse(line)["values"]["navigation_rmse_m"].get<double>());
  EXPECT_GT(tried.size(), 1U) << "the setting has no influence on this walk";

  std::istringstream history(text_of("tuned/history.csv"));
  std::string line, last_value;
  while (std::getline(history, line)) {
    const std::size_t value = line.find(',', line.find(',') + 1) + 1;
    last_value = line.substr(value, line.find(',', value) - value);
  }
  ASSERT_LE(gaitslam("run steered.yaml slam.vision.sigma_px=" + last_value + " --out run").exit_code, 1);
  const json run = json::parse(text_of("run/seed-1/score.json"));
  EXPECT_TRUE(tried.contains(run["metrics"]["navigation_rmse_m"]["value"].get<double>())) << last_value;
}

}  // namespace
