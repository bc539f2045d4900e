#include "sim/result/limits.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::result {
namespace {

using scenario::Bound, scenario::MetricLimit;
using testing::HasSubstr, testing::Not;

constexpr const char* kAte = "ate_se3_rmse_m";

scenario::Scenario limited(std::vector<MetricLimit> limits, bool filter = true) {
  scenario::Scenario scenario;
  scenario.name = "walk";
  if (filter) scenario.slam.emplace();
  scenario.limits.metrics = std::move(limits);
  scenario.limits.ending = {"completed", "diverged"};
  return scenario;
}

SeedScore seed(std::uint64_t number, std::optional<double> ate, std::optional<double> closed, int code = 0) {
  return {number,
          scenario::Ending::completed,
          code,
          {{kAte, "m", ate}, {"loop_closed", "", closed}, {"drift", "m", -1.0}}};
}

/// A seed for each value of a metric.
std::vector<SeedScore> seeds_of(const std::string& metric, const std::vector<double>& values) {
  std::vector<SeedScore> seeds;
  for (const double value : values)
    seeds.push_back({seeds.size() + 1, scenario::Ending::completed, 0, {{metric, "1", value}}});
  return seeds;
}

TEST(Summary, AggregatesAreThoseOfTheSeedsThatHaveTheMetric) {
  const Summary s =
      summarize(limited({}), {seed(1, 0.1, {}), seed(2, 0.4, 1), seed(3, {}, 1), seed(4, 0.1, 1)});
  ASSERT_EQ(s.metrics.size(), 3u);
  const score::Summary& ate = s.metrics[0].over_seeds;
  EXPECT_EQ(ate.n, 3u);
  EXPECT_EQ(ate.median, 0.1);
  EXPECT_NEAR(ate.mean, 0.2, 1e-16);                                    // rounding of the sum
  EXPECT_NEAR(ate.standard_deviation.value(), std::sqrt(0.03), 1e-16);  // 0.01 + 0.01 + 0.04 over 2
  EXPECT_EQ(s.metrics[2].over_seeds.worst, -1);
  EXPECT_FALSE(summarize(limited({}), {seed(1, 0.1, 1)}).metrics[0].over_seeds.standard_deviation);
}

TEST(Summary, TheWorstIsOnTheSideOfTheLimitElseByTheMetricsDefinition) {
  const auto worst = [](const std::string& metric, const std::vector<double>& values,
                        std::vector<MetricLimit> limits = {}) {
    return summarize(limited(std::move(limits)), seeds_of(metric, values)).metrics[0].over_seeds.worst;
  };
  EXPECT_EQ(worst(kAte, {-0.3, 0.1}, {{kAte, "", Bound::at_least, 1}}), -0.3);
  EXPECT_EQ(worst("loop_closed", {0, 1}, {{"loop_closed", "", Bound::at_most, 1}}), 1);
  EXPECT_EQ(worst("loop_landmarks", {12, 18, 15}), 12);  // few landmarks are bad
  EXPECT_EQ(worst(kAte, {0.1, 0.4, 0.2}), 0.4);
  EXPECT_EQ(worst("scale_error_percent", {0.5, -2, 1}), -2);   // an error of either sign is bad
  EXPECT_EQ(worst("nees_position_mean", {2.5, 0.3, 6}), 0.3);  // a tenth of what is expected, against twice
  EXPECT_EQ(worst("nis_gyro_mean", {0.9, 3, 0.4}), 3);
  EXPECT_EQ(worst("a metric of another program", {-3, 2}), 2);
}

TEST(Summary, TheTableShowsHeadlineMetricsFirstAndAllOnRequest) {
  SeedScore one = seed(1, 0.1, 1);
  one.metrics.insert(one.metrics.begin(), {"poses_matched", "1", 100});
  SeedScore other = one;
  other.seed = 2, other.exit_code = 1;
  const Summary summary = summarize(limited({}), {one, other});
  const std::string some = summary_table(summary), all = summary_table(summary, {.all_metrics = true});
  EXPECT_THAT(some, Not(HasSubstr("poses_matched")));
  EXPECT_THAT(some, HasSubstr("--all-metrics"));
  EXPECT_THAT(some, HasSubstr("walk, 2 seeds\n  passed          completed         seed 1\n"
                              "  missed a limit  completed         seed 2\n"));
  EXPECT_LT(all.find(kAte), all.find("poses_matched"));
  EXPECT_THAT(all, HasSubstr("poses_matched"));
  EXPECT_THAT(summary_table(summarize(limited({{"poses_matched", "", Bound::at_least, 1}}), {one})),
              HasSubstr("poses_matched"))
      << "there is a limit on it";
  EXPECT_THAT(summary_table(summary, {.colors = true}), HasSubstr("\033[31mmissed a limit\033[0m"));
  EXPECT_THAT(
      summary_table(summarize(limited({}), {seed(1, 0.1, 1)})),
      testing::AllOf(HasSubstr("walk, 1 seed\n"), HasSubstr("0.1        0.1          -        0.1\n")));
  EXPECT_THAT(summary_table(summarize(limited({}), {{1, scenario::Ending::crashed, 3, {}}})),
              testing::AllOf(HasSubstr("no metrics: no seed has a score\n"), Not(HasSubstr("median"))));
}

TEST(Summary, TheExitCodeIsThatOfTheWorstSeedOrOfAMissedLimitOverSeeds) {
  EXPECT_EQ(exit_code(summarize(limited({}), {seed(1, 0, 0, 0), seed(2, 0, 0, 3), seed(3, 0, 0, 1)})), 3);
  for (const auto& [aggregate, bound, value, code] : {std::tuple("median", Bound::at_most, 0.2, 0),
                                                      {"median", Bound::at_most, 0.19, 1},
                                                      {"mean", Bound::at_most, 0.31, 0},
                                                      {"mean", Bound::at_most, 0.29, 1},
                                                      {"worst", Bound::at_most, 0.59, 1},
                                                      {"worst", Bound::at_least, 0.1, 0},
                                                      {"worst", Bound::at_least, 0.11, 1}})
    EXPECT_EQ(
        exit_code(summarize(limited({{kAte, aggregate, bound, value}}), seeds_of(kAte, {0.1, 0.2, 0.6}))),
        code)
        << aggregate << " " << value;
}

TEST(Summary, ALimitOverSeedsIsMissedIfOneOfThemHasNoValue) {
  const MetricLimit median{kAte, "median", Bound::at_most, 1};
  EXPECT_EQ(exit_code(summarize(limited({median}), {seed(1, {}, 1)})), 1);
  EXPECT_EQ(exit_code(summarize(limited({median}, false), {seed(1, {}, 1)})), 0) << "no filter was to run";
  for (const bool filter : {true, false}) {  // without a filter: a metric of the walk itself
    const Summary summary =
        summarize(limited({median}, filter), {seed(1, 0.1, 1), seed(2, {}, 1), seed(3, {}, 1)});
    EXPECT_EQ(exit_code(summary), 1);
    EXPECT_THAT(summary_table(summary),
                HasSubstr("limit ate_se3_rmse_m.median at_most 1: -  MISSED: no value of 2 of 3 seeds\n"));
    EXPECT_EQ(to_json(summary)["limits"][0].dump(),
              R"({"metric":"ate_se3_rmse_m.median","at_most":1.0,"value":null,"passed":false,)"
              R"("reason":"no value of 2 of 3 seeds"})");
  }
}

TEST(Summary, ARunWithoutAScoreCrashedOrWasNotStarted) {
  EXPECT_EQ(without_score(1, 3).ending, scenario::Ending::crashed);
  EXPECT_EQ(without_score(1, 2).ending, scenario::Ending::not_started);
}

TEST(Summary, TheFileContainsEverythingUnderItsName) {
  const files::TemporaryFolder root;
  write_summary(root / "summary.json", summarize(limited({{kAte, "median", Bound::at_most, 0.2}}),
                                                 {seed(1, 0.1, {}), seed(2, 0.3, {}, 1)}));
  const auto json = nlohmann::json::parse(files::read_text(root / "summary.json"));
  EXPECT_EQ(json["format_version"], 1);
  EXPECT_EQ(json["scenario"], "walk");
  EXPECT_EQ(json["seeds"][1]["exit_code"], 1);
  EXPECT_EQ(json["metrics"][kAte]["n"], 2);
  EXPECT_EQ(json["metrics"][kAte]["worst"], 0.3);
  EXPECT_TRUE(json["metrics"]["loop_closed"]["sd"].is_null());
  EXPECT_EQ(json["limits"][0].dump(),
            R"({"at_most":0.2,"metric":"ate_se3_rmse_m.median","passed":true,"value":0.2})");
}

TEST(Limits, AMissedLimitIsExitCodeOneAndAForbiddenEndingThree) {
  using enum scenario::Ending;
  const MetricLimit error{"rmse_m", "", Bound::at_most, 0.1},
      landmarks{"loop_landmarks", "", Bound::at_least, 3}, median{"rmse_m", "median", Bound::at_most, 0.1};
  struct Case {
    MetricLimit limit;
    std::optional<double> value;
    int code;
    scenario::Ending ending = completed;
    bool filter = true;
  };
  for (const Case& c :
       {Case{error, 0.1, 0}, Case{error, 0.2, 1}, Case{landmarks, 3, 0}, Case{landmarks, 2, 1},
        Case{error, 0.2, 1, diverged}, Case{error, 0.1, 3, fell}, Case{median, 0.2, 0}, Case{error, {}, 1},
        Case{error, {}, 0, completed, false}, Case{error, 0.2, 1, completed, false}}) {
    const scenario::Scenario scenario = limited({c.limit}, c.filter);
    const auto judged = judge_run(scenario, [&](const std::string&) { return c.value; });
    EXPECT_EQ(exit_code(scenario, c.ending, judged), c.code)
        << c.limit.metric << c.limit.aggregate << " " << c.value.value_or(-1);
  }
  EXPECT_TRUE(to_json(judge(limited({}, false), median, {})).at("passed").is_null());
}

}  // namespace
}  // namespace sim::result
