#include "sim/result/limits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::result {
namespace {

namespace fs = std::filesystem;

class SummaryTest : public testing::Test {
 protected:
  void write_score(std::uint64_t seed, const std::string& text) {
    const fs::path folder = root_ / ("seed-" + std::to_string(seed));
    fs::create_directories(folder);
    std::ofstream(folder / "score.json") << text;
  }
  const files::TemporaryFolder folder_;
  const fs::path root_ = folder_ / "results";
};

SeedScore seed(std::uint64_t number, std::optional<double> ate, std::optional<double> closed, int code = 0) {
  return {number,
          scenario::Ending::completed,
          code,
          {{"ate_se3_rmse_m", "m", ate}, {"loop_closed", "", closed}, {"drift", "m", -1.0}}};
}

scenario::Scenario scenario_limiting(std::vector<scenario::MetricLimit> limits) {
  scenario::Scenario scenario;
  scenario.name = "walk";
  scenario.slam.emplace();
  scenario.limits.metrics = std::move(limits);
  return scenario;
}

TEST_F(SummaryTest, AggregatesAreThoseOfTheSeedsThatHaveTheMetric) {
  const Summary s =
      summarize(scenario_limiting({}), {seed(1, 0.1, {}), seed(2, 0.4, 1), seed(3, {}, 1), seed(4, 0.1, 1)});
  ASSERT_EQ(s.metrics.size(), 3u);
  EXPECT_EQ(s.metrics[0].over_seeds.n, 3u);
  EXPECT_EQ(s.metrics[0].over_seeds.median, 0.1);
  EXPECT_NEAR(s.metrics[0].over_seeds.mean, 0.2, 1e-16);  // rounding of the sum
  EXPECT_NEAR(s.metrics[0].over_seeds.standard_deviation.value(), std::sqrt(0.03),
              1e-16);  // 0.01 + 0.01 + 0.04 over 2
  EXPECT_EQ(s.metrics[2].over_seeds.worst, -1);
}

TEST_F(SummaryTest, WorstIsOnTheSideThatTheLimitForbids) {
  const std::vector<SeedScore> seeds{seed(1, -0.3, 0), seed(2, 0.1, 1)};
  const scenario::MetricLimit at_least{"ate_se3_rmse_m", "", scenario::Bound::at_least, 1},
      at_most{"loop_closed", "", scenario::Bound::at_most, 1};
  EXPECT_EQ(summarize(scenario_limiting({at_least}), seeds).metrics[0].over_seeds.worst, -0.3);
  EXPECT_EQ(summarize(scenario_limiting({at_most}), seeds).metrics[1].over_seeds.worst, 1);
}

TEST_F(SummaryTest, WithoutALimitTheWorstIsThatOfTheMetricsDefinition) {
  const auto worst = [](const std::string& metric, const std::vector<double>& values) {
    std::vector<SeedScore> seeds;
    for (const double value : values)
      seeds.push_back({1, scenario::Ending::completed, 0, {{metric, "1", value}}});
    return summarize(scenario_limiting({}), seeds).metrics[0].over_seeds.worst;
  };
  EXPECT_EQ(worst("loop_landmarks", {12, 18, 15}), 12);  // few landmarks are bad
  EXPECT_EQ(worst("ate_se3_rmse_m", {0.1, 0.4, 0.2}), 0.4);
  EXPECT_EQ(worst("scale_error_percent", {0.5, -2, 1}), -2);   // an error of either sign is bad
  EXPECT_EQ(worst("nees_position_mean", {2.5, 0.3, 6}), 0.3);  // a tenth of what is expected, against twice
  EXPECT_EQ(worst("nis_gyro_mean", {0.9, 3, 0.4}), 3);
  EXPECT_EQ(worst("a metric of another program", {-3, 2}), 2);
}

TEST_F(SummaryTest, ALimitOnTheWorstSeedIsJudgedOnItsOwnSide) {
  const scenario::MetricLimit above{"nees_position_mean", "worst", scenario::Bound::at_most, 5},
      below{"nees_position_mean", "worst", scenario::Bound::at_least, 1};
  std::vector<SeedScore> seeds;
  for (const double value : {0.2, 6.0})
    seeds.push_back({1, scenario::Ending::completed, 0, {{"nees_position_mean", "1", value}}});
  const Summary summary = summarize(scenario_limiting({above, below}), seeds);
  EXPECT_TRUE(summary.limits.at(0).missed());
  EXPECT_TRUE(summary.limits.at(1).missed());
}

TEST_F(SummaryTest, OneSeedHasNoStandardDeviation) {
  const Summary one = summarize(scenario_limiting({}), {seed(1, 0.1, 1)});
  EXPECT_FALSE(one.metrics[0].over_seeds.standard_deviation);
  fs::create_directories(root_);
  write_summary(root_ / "summary.json", one);
  std::ifstream in(root_ / "summary.json");
  EXPECT_TRUE(nlohmann::json::parse(in)["metrics"]["ate_se3_rmse_m"]["sd"].is_null());
  const std::string table = summary_table(one);
  EXPECT_NE(table.find("walk, 1 seed\n"), table.npos) << table;
  EXPECT_NE(table.find("0.1        0.1          -        0.1\n"), table.npos) << table;
  EXPECT_NE(
      summary_table(summarize(scenario_limiting({}), {seed(1, 0.1, 1), seed(2, 0.1, 1)})).find("2 seeds\n"),
      std::string::npos);
}

TEST_F(SummaryTest, TheTableShowsHeadlineMetricsFirstAndAllOnRequest) {
  SeedScore one = seed(1, 0.1, 1);
  one.metrics.insert(one.metrics.begin(), {"poses_matched", "1", 100});
  SeedScore other = one;
  other.seed = 2, other.exit_code = 1;
  const Summary summary = summarize(scenario_limiting({}), {one, other});
  const std::string some = summary_table(summary), all = summary_table(summary, {.all_metrics = true});
  EXPECT_EQ(some.find("poses_matched"), some.npos) << some;
  EXPECT_NE(some.find("--all-metrics"), some.npos);
  EXPECT_LT(all.find("ate_se3_rmse_m"), all.find("poses_matched"));
  EXPECT_NE(all.find("poses_matched"), all.npos);
  EXPECT_NE(summary_table(
                summarize(scenario_limiting({{"poses_matched", "", scenario::Bound::at_least, 1}}), {one}))
                .find("poses_matched"),
            std::string::npos)
      << "there is a limit on it";
  EXPECT_NE(
      some.find("  passed          completed         seed 1\n  missed a limit  completed         seed 2\n"),
      some.npos)
      << some;
  EXPECT_NE(summary_table(summary, {.colors = true}).find("\033[31mmissed a limit\033[0m"),
            std::string::npos);
}

TEST_F(SummaryTest, WithoutScoresTheTableHasNoMetrics) {
  const std::string table = summary_table(summarize(
      scenario_limiting({}), {{1, scenario::Ending::crashed, 3, {}}, {2, scenario::Ending::crashed, 3, {}}}));
  EXPECT_NE(table.find("no metrics: no seed has a score\n"), table.npos) << table;
  EXPECT_EQ(table.find("median"), table.npos) << table;
}

TEST_F(SummaryTest, ALimitOverSeedsThatIsMissedMakesTheExitCodeOne) {
  const std::vector<SeedScore> seeds{seed(1, 0.1, 1), seed(2, 0.2, 1), seed(3, 0.6, 1)};
  const auto code = [&](const std::string& aggregate, scenario::Bound bound, double value) {
    return exit_code(summarize(scenario_limiting({{"ate_se3_rmse_m", aggregate, bound, value}}), seeds));
  };
  EXPECT_EQ(code("median", scenario::Bound::at_most, 0.2), 0);
  EXPECT_EQ(code("median", scenario::Bound::at_most, 0.19), 1);
  EXPECT_EQ(code("mean", scenario::Bound::at_most, 0.31), 0);
  EXPECT_EQ(code("mean", scenario::Bound::at_most, 0.29), 1);
  EXPECT_EQ(code("worst", scenario::Bound::at_most, 0.59), 1);
  EXPECT_EQ(code("worst", scenario::Bound::at_least, 0.1), 0);
}

TEST_F(SummaryTest, ALimitOnAMetricOfNoSeedIsMissedUnlessNoFilterWasToRun) {
  scenario::Scenario scenario =
      scenario_limiting({{"ate_se3_rmse_m", "median", scenario::Bound::at_most, 1}});
  EXPECT_EQ(exit_code(summarize(scenario, {seed(1, {}, 1)})), 1);
  scenario.slam.reset();
  EXPECT_EQ(exit_code(summarize(scenario, {seed(1, {}, 1)})), 0);
}

TEST_F(SummaryTest, ALimitOverSeedsIsMissedIfOneOfThemHasNoValue) {
  const std::vector<SeedScore> seeds{seed(1, 0.1, 1), seed(2, {}, 1), seed(3, {}, 1)};
  for (const char* const aggregate : {"worst", "median", "mean"})
    for (const bool filter : {true, false}) {
      scenario::Scenario scenario =
          scenario_limiting({{"ate_se3_rmse_m", aggregate, scenario::Bound::at_most, 1}});
      if (!filter) scenario.slam.reset();  // a metric of the walk itself
      const Summary summary = summarize(scenario, seeds);
      EXPECT_EQ(exit_code(summary), 1) << aggregate;
      EXPECT_EQ(summary.metrics[0].over_seeds.n, 1u);
      const std::string table = summary_table(summary);
      EXPECT_NE(table.find(std::string("limit ate_se3_rmse_m.") + aggregate +
                           " at_most 1: -  MISSED: no value of 2 of 3 seeds\n"),
                table.npos)
          << table;
      EXPECT_EQ(to_json(summary)["limits"][0].dump(),
                std::string(R"({"metric":"ate_se3_rmse_m.)") + aggregate +
                    R"(","at_most":1.0,"value":null,"passed":false,"reason":"no value of 2 of 3 seeds"})");
    }
}

TEST_F(SummaryTest, TheExitCodeIsThatOfTheWorstSeed) {
  EXPECT_EQ(
      exit_code(summarize(scenario_limiting({}), {seed(1, 0, 0, 0), seed(2, 0, 0, 3), seed(3, 0, 0, 1)})), 3);
}

TEST_F(SummaryTest, ScoresAreReadFromTheSeedsFolders) {
  write_score(
      7,
      R"({"ending":"fell","metrics":{"rmse_m":{"value":0.5,"unit":"m"},"x":{"value":null,"unit":"","reason":"r"}}})");
  const SeedScore score = read_seed_score(root_, 7, 3);
  EXPECT_EQ(score.ending, scenario::Ending::fell);
  ASSERT_EQ(score.metrics.size(), 2u);
  EXPECT_EQ(score.metrics[0].value, 0.5);
  EXPECT_FALSE(score.metrics[1].value);
}

TEST_F(SummaryTest, AProcessWithoutAScoreCrashedOrDidNotStart) {
  EXPECT_EQ(read_seed_score(root_, 1, 3).ending, scenario::Ending::crashed);
  EXPECT_EQ(read_seed_score(root_, 1, 2).ending, scenario::Ending::not_started);
  EXPECT_THROW(read_seed_score(root_, 1, 0), files::FileError);
}

TEST_F(SummaryTest, ABrokenScoreIsAnErrorThatNamesTheFile) {
  for (const char* text :
       {"", "{", "[]", R"({"ending":1,"metrics":{}})", R"({"ending":"fell","metrics":{"a":3}})"}) {
    write_score(1, text);
    try {
      read_seed_score(root_, 1, 0);
      ADD_FAILURE() << text;
    } catch (const files::FileError& e) {
      EXPECT_NE(std::string(e.what()).find("seed-1/score.json"), std::string::npos);
    }
  }
}

TEST_F(SummaryTest, TheFileContainsEverythingUnderItsName) {
  const scenario::MetricLimit limit{"ate_se3_rmse_m", "median", scenario::Bound::at_most, 0.2};
  const Summary summary = summarize(scenario_limiting({limit}), {seed(1, 0.1, {}), seed(2, 0.3, {}, 1)});
  fs::create_directories(root_);
  write_summary(root_ / "summary.json", summary);
  std::ifstream in(root_ / "summary.json");
  const auto json = nlohmann::json::parse(in);
  EXPECT_EQ(json["format_version"], 1);
  EXPECT_EQ(json["scenario"], "walk");
  EXPECT_EQ(json["seeds"][1]["exit_code"], 1);
  EXPECT_EQ(json["metrics"]["ate_se3_rmse_m"]["n"], 2);
  EXPECT_EQ(json["metrics"]["ate_se3_rmse_m"]["worst"], 0.3);
  EXPECT_TRUE(json["metrics"]["loop_closed"]["median"].is_null());
  EXPECT_EQ(json["limits"][0]["metric"], "ate_se3_rmse_m.median");
  EXPECT_EQ(json["limits"][0]["at_most"], 0.2);
  EXPECT_EQ(json["limits"][0]["passed"], true);
}

const scenario::MetricLimit kError{"rmse_m", "", scenario::Bound::at_most, 0.1},
    kLandmarks{"loop_landmarks", "", scenario::Bound::at_least, 3},
    kMedian{"rmse_m", "median", scenario::Bound::at_most, 0.1};

scenario::Scenario scenario_with(std::vector<scenario::MetricLimit> limits, bool filter = true) {
  scenario::Scenario scenario;
  if (filter) scenario.slam.emplace();
  scenario.limits.metrics = std::move(limits);
  scenario.limits.ending = {"completed", "diverged"};
  return scenario;
}

int code(const scenario::Scenario& scenario, std::optional<double> value,
         scenario::Ending ending = scenario::Ending::completed) {
  return exit_code(scenario, ending, judge_run(scenario, [&](const std::string&) { return value; }));
}

TEST(Limits, AMissedLimitIsExitCodeOneAndAForbiddenEndingThree) {
  EXPECT_EQ(code(scenario_with({kError}), 0.1), 0);
  EXPECT_EQ(code(scenario_with({kError}), 0.2), 1);
  EXPECT_EQ(code(scenario_with({kLandmarks}), 3), 0);
  EXPECT_EQ(code(scenario_with({kLandmarks}), 2), 1);
  EXPECT_EQ(code(scenario_with({kError}), 0.2, scenario::Ending::diverged), 1);
  EXPECT_EQ(code(scenario_with({kError}), 0.1, scenario::Ending::fell), 3);
}

TEST(Limits, OfARunAreThoseWithoutAnAggregate) { EXPECT_EQ(code(scenario_with({kMedian}), 0.2), 0); }

TEST(Limits, AnAbsentValueMissesItsLimitUnlessNoFilterWasToRun) {
  EXPECT_EQ(code(scenario_with({kError}), {}), 1);
  EXPECT_EQ(code(scenario_with({kError}, false), {}), 0);
  EXPECT_EQ(code(scenario_with({kError}, false), 0.2), 1);  // a value of the walk itself is judged
}

TEST(Limits, AreWrittenWithTheirValues) {
  const auto json = to_json(judge(scenario_with({}), kMedian, 0.2));
  EXPECT_EQ(json.dump(), R"({"metric":"rmse_m.median","at_most":0.1,"value":0.2,"passed":false})");
  EXPECT_TRUE(to_json(judge(scenario_with({}, false), kMedian, {})).at("passed").is_null());
}

}  // namespace
}  // namespace sim::result
