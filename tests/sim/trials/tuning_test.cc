// The search, on functions with a known minimum. Tunings of a short walk give the same answer for any
// division of the work, and when resumed from a part of the log.
#include "sim/trials/tuning.h"

#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/result/result_folder.h"
#include "tests/sim/trials/synthetic_result.h"

namespace sim::trials {
namespace {

using testing::HasSubstr;

template <typename F>
std::vector<double> best_of(CmaEs search, int generations, const F& value) {
  std::vector<double> best;
  for (int g = 0; g < generations; ++g) {
    const auto asked = search.ask();
    std::vector<double> values;
    for (const auto& x : asked) {
      values.push_back(value(x));
      if (best.empty() || values.back() < value(best)) best = x;
    }
    search.tell(values);
  }
  return best;
}

// A valley a hundred times as long as wide, along a diagonal.
double valley(const std::vector<double>& x) {
  const double along = x[0] + x[1] - 1.3, across = x[0] - x[1] - 0.3;
  return along * along + 1e4 * across * across;
}

TEST(CmaEs, FindsTheEndOfAStretchedValley) {
  const auto best = best_of(CmaEs({0.1, 0.9}, 0.25, 8, 1), 100, valley);
  EXPECT_NEAR(best[0], 0.8, 1e-4);
  EXPECT_NEAR(best[1], 0.5, 1e-4);
}

TEST(CmaEs, FindsAMinimumOnTheEdgeAndNeverLeavesTheCube) {
  const auto best = best_of(CmaEs({0.5, 0.5, 0.5}, 0.3, 10, 2), 80, [](const std::vector<double>& x) {
    for (const double part : x) EXPECT_TRUE(part >= 0 && part <= 1);
    return x[0] + std::abs(x[1] - 0.25) - x[2];
  });
  EXPECT_NEAR(best[0], 0, 1e-3);
  EXPECT_NEAR(best[1], 0.25, 1e-3);
  EXPECT_NEAR(best[2], 1, 1e-3);
}

TEST(CmaEs, AsksForTheSamePointsOnlyWithTheSameSeed) {
  EXPECT_EQ(CmaEs({0.5}, 0.2, 6, 3).ask(), CmaEs({0.5}, 0.2, 6, 3).ask());
  EXPECT_NE(CmaEs({0.5}, 0.2, 6, 3).ask(), CmaEs({0.5}, 0.2, 6, 4).ask());
}

// Only the order of values counts.
TEST(CmaEs, DoesNotDependOnHowMuchWorseAFailureIs) {
  const auto with_failures = [](double failure) {
    return best_of(CmaEs({0.4, 0.4}, 0.25, 8, 5), 20, [&](const std::vector<double>& x) {
      return x[0] > 0.6 ? failure : valley({x[0] + 0.3, x[1]});
    });
  };
  EXPECT_EQ(with_failures(1e6), with_failures(1e9));
}

JobRecord success(double nll) {
  return {"k", 1, "completed", "", {{"pose_nll", nll}, {"lasted_fraction", 1}}};
}
JobRecord failure(double lasted) { return {"k", 1, "diverged", "lost", {{"lasted_fraction", lasted}}}; }
double loss(const JobRecord& record) { return loss_of(record, Objective::pose_nll); }

TEST(Failure, IsWorseThanAnySuccessAndWorseTheEarlierAndTheMoreRunsFail) {
  EXPECT_LT(loss(success(-20)), loss(success(1e5)));
  EXPECT_LT(loss(success(1e300)), loss(failure(1)));
  EXPECT_LT(loss(failure(0.9)), loss(failure(0.1)));
  EXPECT_TRUE(std::isfinite(loss(failure(0))));
  const JobRecord good = success(-5), late = failure(0.99), early = failure(0.01);
  EXPECT_LT(mean_loss({&good, &early}, Objective::pose_nll), mean_loss({&late, &late}, Objective::pose_nll));
}

constexpr const char* kSpec = R"(
parameters:
  slam.gyro.sigma_rad_s: {from: 0.001, to: 0.3, start: 0.1}
  slam.vision.sigma_px: {from: 0.1, to: 30, start: 20}
training: [{recordings: walks, seeds: 1..3}]
holdout: [{recordings: walks, seeds: 4..6}]
trials: 19
population: 5
)";

class Tunings : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("gaitslam tunings " + std::to_string(getpid()));
    tests::write_result(folder_ / "walks/seed-1", tests::short_walk(24));
    for (int seed = 2; seed <= 6; ++seed) {
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
  /// most: receives the largest number of tasks given at once; they run in reverse order.
  static TuningResult tuned(const Spec& spec, const std::string& out, std::size_t* most = nullptr) {
    const RunTasks run_tasks = [&](const std::vector<Task>& tasks, JobLog& log) {
      if (most) *most = std::max(*most, tasks.size());
      const auto run = [&](const Task& task) {
        log.add({run_task(task, [&](const auto&, const auto&) {
          return std::make_shared<const Recording>(load(task.recording));
        })});
      };
      most ? std::for_each(tasks.rbegin(), tasks.rend(), run)
           : std::for_each(tasks.begin(), tasks.end(), run);
    };
    return tune(spec, folder_ / out, run_tasks, "test", [](double, const std::string&) {});
  }
  static std::map<std::string, std::string> answer_of(const std::string& out) {
    return tests::files(folder_ / out, "trials.jsonl");
  }

  static inline fs::path folder_;
};

TEST_F(Tunings, GiveTheSameAnswerInAnyOrderOfTheTasksAndFromAPartOfTheLog) {
  std::size_t most = 0;
  EXPECT_EQ(tuned(spec(), "one").text, tuned(spec(), "reverse", &most).text);
  EXPECT_GE(most, 15U) << "a generation at once: five settings of three runs";
  const auto answer = answer_of("one");
  EXPECT_TRUE(answer.contains("tune.json"));
  EXPECT_EQ(std::ranges::count(answer.at("history.csv"), '\n'), 20) << "the last generation is cut off";
  const std::string log = files::read_text(folder_ / "one/trials.jsonl");
  fs::create_directory(folder_ / "half");
  files::write_text(folder_ / "half/trials.jsonl", log.substr(0, log.size() / 2));
  tuned(spec(), "half");
  for (const char* other : {"reverse", "half"}) {
    EXPECT_EQ(files::read_text(folder_ / other / "trials.jsonl"), log);
    EXPECT_EQ(tests::differences(answer, answer_of(other)), std::vector<std::string>{}) << other;
  }
}

TEST_F(Tunings, AreAcceptedOnlyByTheIntervalOfTheirPairs) {
  const auto judged = [](const std::string& holdout,
                         const std::string& range = "slam.vision.sigma_px: {from: 0.1, to: 30, start: 20}") {
    std::ofstream(folder_ / "judged.yaml")
        << "parameters: {" + range + "}\ntraining: [{recordings: walks, seeds: 1}]\n" +
               "holdout: [{recordings: walks, " + holdout + "}]\ntrials: 7\npopulation: 5\n";
    const TuningResult result = tuned(read_spec(folder_ / "judged.yaml"), "judged");
    const nlohmann::json change = tests::json_of(folder_ / "judged/tune.json")["change"];
    EXPECT_EQ(result.accepted, change["verdict"] == "better");
    EXPECT_EQ(result.accepted, fs::exists(folder_ / "judged/best.yaml"));
    EXPECT_NE(result.text.find(result.judgment), std::string::npos);
    fs::remove_all(folder_ / "judged");
    return change;
  };
  const nlohmann::json better = judged("seeds: 2..3");
  EXPECT_EQ(better["verdict"], "better") << better;
  EXPECT_EQ(better["pairs"], 2);
  EXPECT_LT(better["interval_95"][1], 0);
  const nlohmann::json one = judged("seeds: 2");
  EXPECT_EQ(one["verdict"], "undecided") << "one pair has no interval";
  EXPECT_THAT(one["text"], HasSubstr("add recordings to holdout and run the command again: it reuses"));
  const nlohmann::json none =
      judged("seeds: 2..3", "slam.known_landmarks.sigma_m: {from: 0.001, to: 0.1, start: 0.005}");
  EXPECT_EQ(none["text"], "nothing better found: none of 7 settings has a lower loss than the start");
  EXPECT_EQ(none["verdict"], "unchanged");
}

TEST_F(Tunings, LeaveAnOverlayWithTheBestValuesIfBetterOnTheHoldout) {
  const TuningResult result = tuned(spec(), "better");
  ASSERT_TRUE(result.accepted) << result.text;  // the start's image noise is far too large
  const nlohmann::json json = tests::json_of(folder_ / "better" / "tune.json");
  const scenario::Scenario scenario = scenario::read_scenario(folder_ / "walks/seed-1/scenario.yaml",
                                                              {{}, {}, {folder_ / "better" / "best.yaml"}})
                                          .scenario;
  EXPECT_EQ(scenario.slam->gyro.sigma_rad_s, json["parameters"][0]["best"]);
  EXPECT_EQ(scenario.slam->vision.sigma_px, json["parameters"][1]["best"]);
  const nlohmann::json& values = json["training"]["values"]["pose_nll"];
  double start = 0, best = 0;
  for (int run = 0; run < 3; ++run)
    start += values["start"][run].get<double>(), best += values["best"][run].get<double>();
  EXPECT_LT(best, start);
}

// A folder of files that look like recordings, which is enough for a spec.
class SpecFile : public testing::Test {
 protected:
  SpecFile() {
    for (int seed = 1; seed <= 3; ++seed) {
      const fs::path result = folder_ / ("walks/seed-" + std::to_string(seed));
      fs::create_directories(result / "recording");
      std::ofstream(result / "recording" / "manifest.csv") << '\n';
      std::ofstream(result / "scenario.yaml")
          << "seed: " << seed
          << "\nwalk: {commands: [stand: {duration_s: 1}]}\ncamera: {}\nslam: {gyro.sigma_rad_s: 0.02}\n";
    }
  }
  Spec read(const std::string& text) const {
    std::ofstream(folder_ / "spec.yaml") << text;
    return read_spec(folder_ / "spec.yaml");
  }
  /// The error of reading the spec, without the folder.
  std::string complaint(const std::string& text) const {
    const std::string what = files::error_of([&] { read(text); });
    return what.substr(std::min(what.find("spec.yaml"), what.size()));
  }

  static inline const std::string kGyro = "parameters: {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.1}}\n";
  static constexpr const char* kSides =
      "training: [{recordings: walks, seeds: 1..2}]\nholdout: [{recordings: walks/seed-3}]\n";
  files::TemporaryFolder folder_;
};

TEST_F(SpecFile, StatesWhatIsTunedOnWhichRecordingsAndHow) {
  const Spec spec = read(
      "parameters:\n  slam.gyro.sigma_rad_s: {from: 0.001, to: 0.1}\n"
      "  slam.vision.sigma_px: {from: 0.1, to: 4, start: 2, also: [slam.vision.gate_sigma_px]}\n"
      "training: [{recordings: walks, seeds: '1,3', set: [slam.height.sigma_m=0.1]}]\n"
      "holdout: [{recordings: walks/seed-2}]\nobjective: rmse_m\ntrials: 90\nseed: 7\n");
  EXPECT_EQ(spec.name, "spec");
  ASSERT_EQ(spec.parameters.size(), 2U);
  EXPECT_EQ(spec.parameters[0].start, 0.02);  // from the recorded scenario
  EXPECT_EQ(spec.parameters[1].also, std::vector<std::string>{"slam.vision.gate_sigma_px"});
  ASSERT_EQ(spec.training.size(), 2U);
  EXPECT_EQ(spec.training[1].folder, (folder_ / "walks/seed-3"));
  EXPECT_EQ(spec.training[1].name, "walks/seed-3");
  EXPECT_EQ(spec.objective, Objective::rmse_m);
  EXPECT_EQ(spec.trials, 90);
}

TEST_F(SpecFile, IsRejectedWithThePlaceOfTheError) {
  const std::string range = "{from: 0.001, to: 0.1}";
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"parameters: {slam.gyro.sigma_rads: " + range + "}\n",
       "spec.yaml:1:14: slam.gyro.sigma_rads: unknown key; did you mean"},
      {"parameters: {walk.step_length_m: " + range + "}\n",
       "spec.yaml:1:14: walk.step_length_m: affects the recording"},
      {"parameters: {slam.gyro.enabled: " + range + "}\n",
       "spec.yaml:1:14: slam.gyro.enabled: is true or false"},
      {"parameters: {slam.gyro.sigma_rad_s: {from: 0.1, to: 1}}\n" + std::string(kSides),
       "starts at 0.02, outside"},
      {kGyro, "training: missing"},
      {kGyro + "training: [{recordings: walks, seeds: 1}]\n", "holdout: missing"},
      {kGyro + "training: [{recordings: walks}]\n", "spec.yaml:2:25: recordings: "},
      {kGyro + "training: [{recordings: walks, seeds: 1..9}]\n", "has no finished recording"},
      {kGyro + "training: [{recordings: walks, seeds: 3..1}]\n", "spec.yaml:2:39: seeds: "},
      {kGyro + "training: []\n", "spec.yaml:2:11: training: expected a list"},
      {kGyro + "training: [{recordings: walks, seeds: 1..3}]\nholdout: [{recordings: walks/seed-3}]\n",
       "spec.yaml:3:11: holdout: seed 3 of scenario is also in the training"},
      {kGyro +
           "training: [{recordings: walks/seed-2}]\nholdout: [{recordings: walks/seed-2, set: [seed=9]}]\n",
       "spec.yaml:3:11: holdout: seed 2 of scenario is also in the training"},
      {kGyro + kSides + "objective: nll\n", "spec.yaml:4:12: objective: "},
      {kGyro + kSides + "trials: 10\n", "too few for a population of 10"},
      {kGyro + kSides + "trails: 20\n", "spec.yaml:4:1: trails: unknown key; did you mean 'trials'?"},
      {"- a\n", "expected a tuning"},
  };
  for (const auto& [text, complaint_] : wrong) EXPECT_THAT(complaint(text), HasSubstr(complaint_)) << text;
}

TEST_F(SpecFile, MayTakeEverythingButTheWalkFromAnotherScenario) {
  const std::string spec = kGyro +
                           "training: [{recordings: walks/seed-1, scenario: new.yaml}]\n"
                           "holdout: [{recordings: walks/seed-3}]\n";
  std::ofstream(folder_ / "new.yaml")
      << "walk: {commands: [stand: {duration_s: 1}]}\ncamera: {}\nslam: {gyro.sigma_rad_s: 0.05}\n";
  EXPECT_EQ(read(spec).parameters[0].start, 0.05);
  std::ofstream(folder_ / "new.yaml") << "walk: {commands: [stand: {duration_s: 2}]}\ncamera: {}\nslam: {}\n";
  EXPECT_THAT(complaint(spec), HasSubstr("spec.yaml:2:12: walk.commands: is "));
}

TEST_F(SpecFile, MayNameScenariosWhoseRecordingsTheCacheHas) {
  std::ofstream(folder_ / "walk.yaml")
      << "seed: 7\nwalk: {commands: [stand: {duration_s: 1}]}\ncamera: {}\nslam: {gyro.sigma_rad_s: 0.05}\n";
  const Spec spec = read(kGyro +
                         "training: [{scenario: walk.yaml, seeds: 2..4, set: [slam.height.sigma_m=0.1]}]\n"
                         "holdout: [{scenario: walk.yaml}]\n");
  ASSERT_EQ(spec.training.size(), 3U);
  EXPECT_EQ(spec.training[1].name, "walk/seed-3");
  EXPECT_EQ(spec.training[1].folder, "");
  EXPECT_EQ(spec.training[1].read.scenario.seed, 3U);
  EXPECT_EQ(spec.training[1].read.scenario.slam->height.sigma_m, 0.1);
  EXPECT_EQ(spec.holdout[0].recorded_seed, 7U);
  EXPECT_EQ(spec.parameters[0].start, 0.05);
  EXPECT_THAT(complaint(kGyro + "training: [{seeds: 1..2}]\n"),
              HasSubstr("spec.yaml:2:12: training: expected a scenario"));
  EXPECT_THROW(read(kGyro + "training: [{scenario: none.yaml}]\n"), scenario::ConfigError);
}

}  // namespace
}  // namespace sim::trials
