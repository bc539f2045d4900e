// Tunings of a short walk: the same answer for any number of threads, and after any number of kills.
#include "sim/trials/tuning.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/files/text.h"
#include "sim/sensor_errors/random.h"
#include "tests/sim/result/result_folder.h"
#include "tests/sim/trials/synthetic_result.h"

namespace sim::trials {
namespace {

namespace fs = std::filesystem;

TrialRecord success(double nll) {
  return {"k", 1, "completed", "", {{"pose_nll", nll}, {"lasted_fraction", 1}}};
}
TrialRecord failure(double lasted) { return {"k", 1, "diverged", "lost", {{"lasted_fraction", lasted}}}; }
double loss(const TrialRecord& record) { return loss_of(record, Objective::pose_nll); }

TEST(Failure, IsWorseThanAnySuccessAndTheWorseTheEarlier) {
  EXPECT_LT(loss(success(-20)), loss(success(1e5)));
  EXPECT_LT(loss(success(1e300)), loss(failure(1)));
  EXPECT_LT(loss(failure(0.9)), loss(failure(0.1)));
  EXPECT_TRUE(std::isfinite(loss(failure(0))));
}

TEST(Failure, OfOneRunIsBetterThanOfTwo) {
  const TrialRecord good = success(-5), late = failure(0.99), early = failure(0.01);
  const auto mean = [](std::vector<const TrialRecord*> records) {
    return mean_loss(records, Objective::pose_nll);
  };
  EXPECT_LT(mean({&good, &early}), mean({&late, &late}));
}

constexpr const char* kSpec = R"(
parameters:
  slam.gyro.sigma_rad_s: {from: 0.001, to: 0.3, start: 0.1}
  slam.height.sigma_m: {from: 0.003, to: 0.3}
training: [{recordings: walks, seeds: 1..3}]
holdout: [{recordings: walks, seeds: 4}]
trials: 26
population: 5
)";

class Tunings : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("gaitslam tunings " + std::to_string(getpid()));
    tests::write_result(folder_ / "walks/seed-1", tests::short_walk(24));
    for (int seed = 2; seed <= 4; ++seed) {
      const fs::path copy = folder_ / "walks" / ("seed-" + std::to_string(seed));
      fs::copy(folder_ / "walks/seed-1", copy, fs::copy_options::recursive);
      std::ofstream(copy / "scenario.yaml", std::ios::app) << "seed: " << seed << '\n';
    }
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static Spec spec() {
    std::ofstream(folder_ / "spec.yaml") << kSpec;
    return read_spec(folder_ / "spec.yaml");
  }
  static TuningResult tuned(const Spec& spec, const std::string& out, int jobs) {
    return tune(spec, folder_ / out, {jobs}, "test", [](const Progress&) {});
  }
  /// Tunes in a process that is killed after so many milliseconds; whether it was done before.
  static bool killed_after(int milliseconds, const Spec& spec, const std::string& out) {
    const pid_t child = fork();
    if (child == 0) {
      tuned(spec, out, 2);
      _exit(0);
    }
    usleep(static_cast<useconds_t>(1000 * milliseconds));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status);
  }
  static std::map<std::string, std::string> answer_of(const std::string& out) {
    return tests::files(folder_ / out, "trials.jsonl");
  }
  static std::size_t finished(const std::string& out) {
    const std::string log = files::read_text(folder_ / out / "trials.jsonl");
    return static_cast<std::size_t>(std::count(log.begin(), log.end(), '\n'));
  }

  static fs::path folder_;
};
fs::path Tunings::folder_;

TEST_F(Tunings, GiveTheSameAnswerForAnyNumberOfThreads) {
  const TuningResult one = tuned(spec(), "one", 1), three = tuned(spec(), "three", 3);
  EXPECT_EQ(one.text, three.text);
  EXPECT_EQ(tests::differences(answer_of("one"), answer_of("three")), std::vector<std::string>{});
  EXPECT_TRUE(answer_of("one").contains("tune.json"));
}

TEST_F(Tunings, KilledAtRandomMomentsLoseNoFinishedTrialAndEndAlike) {
  tuned(spec(), "whole", 1);
  sensor_errors::Random random(20061121, "moments of killing");
  std::size_t before = 0;
  int kills = 0;
  for (bool done = false; !done; ++kills) {
    ASSERT_LT(kills, 200);
    done = killed_after(10 + static_cast<int>(120 * random.uniform()) * (1 + kills / 4), spec(), "killed");
    const std::size_t now = finished("killed");
    EXPECT_GE(now, before);
    before = now;
  }
  EXPECT_GE(kills, 3);  // else the moments say nothing
  EXPECT_EQ(tests::differences(answer_of("whole"), answer_of("killed")), std::vector<std::string>{});
  EXPECT_EQ(finished("whole"), finished("killed"));
}

// Each remote task reads its recording, as a process on another machine does.
TEST_F(Tunings, GiveTheSameAnswerWhereTrialsRunRemotelyAGenerationAtOnce) {
  tuned(spec(), "in threads", 2);
  std::size_t most = 0;
  const RunTasks remote = [&](const std::vector<Task>& tasks, TrialLog& log) {
    most = std::max(most, tasks.size());
    for (const Task& task : tasks) log.add(Runner(1).run(task));
  };
  tune(spec(), folder_ / "remote", {1, remote}, "test", [](const Progress&) {});
  EXPECT_EQ(tests::differences(answer_of("in threads"), answer_of("remote")), std::vector<std::string>{});
  EXPECT_GE(most, 15U) << "a generation is five settings of three runs";
}

TEST_F(Tunings, BetterOnHoldoutLeaveAnOverlayThatSetsTheBestValues) {
  const TuningResult result = tuned(spec(), "better", 2);
  ASSERT_TRUE(result.accepted);  // the start's gyro sigma is ten times too large
  const nlohmann::json json = tests::json_of(folder_ / "better" / "tune.json");
  const scenario::Scenario scenario = scenario::read_scenario(folder_ / "walks/seed-1/scenario.yaml",
                                                              {{}, {}, {folder_ / "better" / "best.yaml"}})
                                          .scenario;
  EXPECT_EQ(scenario.slam->gyro.sigma_rad_s, json["parameters"][0]["best"]);
  EXPECT_EQ(scenario.slam->height.sigma_m, json["parameters"][1]["best"]);
  const nlohmann::json& values = json["training"]["values"]["pose_nll"];
  double start = 0, best = 0;
  for (int run = 0; run < 3; ++run)
    start += values["start"][run].get<double>(), best += values["best"][run].get<double>();
  EXPECT_LT(best, start);
}

// The hold-out run has a gyro a hundred times as noisy as training: what fits there is worse here.
TEST_F(Tunings, WorseOnHoldoutAreRefused) {
  Spec wrong = spec();
  wrong.holdout[0].set.push_back(
      "errors.gyro.sigma_rad_s=0.1");  // what the start expects, and training has not
  wrong.parameters.resize(1);
  const TuningResult result = tuned(wrong, "worse", 2);
  EXPECT_FALSE(result.accepted);
  EXPECT_FALSE(fs::exists(folder_ / "worse" / "best.yaml"));
  EXPECT_EQ(tests::json_of(folder_ / "worse" / "tune.json")["accepted"], false);
}

}  // namespace
}  // namespace sim::trials
