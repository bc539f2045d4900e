#include "sim/regression/verdict.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "sim/sensor_errors/random.h"

namespace sim::regression {
namespace {

using testing::ElementsAre, testing::HasSubstr, testing::Not;

constexpr const char* kError = "ate_se3_rmse_m";  // smaller is better

ScenarioResults results(const std::vector<std::optional<double>>& values, const std::string& metric = kError,
                        std::uint64_t first_seed = 1) {
  ScenarioResults all{"walk", {}, {}};
  for (const auto& value : values)
    all.seeds.push_back({first_seed++, scenario::Ending::completed, 0, {{metric, "m", value}}, "hash"});
  return all;
}

const Gate kTenPercent{kError, 10, 0};

using Values = std::vector<std::optional<double>>;

MetricVerdict judged(const ScenarioResults& before, const ScenarioResults& now, Gate gate = kTenPercent) {
  return compare(before, now, {gate}).metrics.at(0);
}
Verdict verdict(const Values& before, const Values& now, Gate gate = kTenPercent) {
  return judged(results(before, gate.metric), results(now, gate.metric), gate).verdict;
}

Values times(double factor, Values values) {
  for (auto& value : values) value = *value * factor;
  return values;
}

const Values kEight{1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7}, kThree{1.0, 1.1, 1.2};

TEST(Verdict, EightSeedsAreJudgedByToleranceAndSignificance) {
  auto bit = kEight, chance = times(1.5, kEight);
  *bit[3] = std::nextafter(*bit[3], 2);
  for (const std::size_t i : {0u, 3u}) chance[i] = *kEight[i] * 0.4;
  struct Case {
    Values now;
    Verdict verdict;
    Gate gate = kTenPercent;
  };
  for (const Case& c : {Case{kEight, Verdict::identical},
                        {bit, Verdict::same},
                        {times(1.2, kEight), Verdict::fail},
                        {times(0.8, kEight), Verdict::better},
                        {times(1.05, kEight), Verdict::same},
                        {times(1.2, kEight), Verdict::same, {kError, 10, 0.5}},
                        {times(1.2, kEight), Verdict::fail, {kError, 0, 0.2}},
                        {chance, Verdict::undecided}})
    EXPECT_EQ(verdict(kEight, c.now, c.gate), c.verdict) << *c.now[0];
  EXPECT_EQ(verdict({1, {}, 1}, {1, {}, 1}), Verdict::identical);
  const MetricVerdict v = judged(results(kEight), results(times(1.2, kEight)));
  EXPECT_NEAR(*v.p, 2 / 256.0, 1e-15);  // all eight of one sign
  EXPECT_NEAR(*v.baseline, 1.35, 1e-15);
  EXPECT_NEAR(*v.change, 0.2 * 1.35, 1e-12);
  EXPECT_NEAR(v.coverage, 1 - 2 * 5 / 256.0, 1e-15);
  EXPECT_EQ(v.worst_seed, 8u);
}

TEST(Verdict, EachMetricDefinesWhichDirectionIsWorse) {
  const auto eight = [](double n) { return Values(8, n); };
  const Gate landmarks{"loop_landmarks", 10, 0}, scale{"scale_error_percent", 0, 0.5};
  EXPECT_EQ(verdict(eight(20), eight(10), landmarks), Verdict::fail);
  EXPECT_EQ(verdict(eight(10), eight(20), landmarks), Verdict::better);
  EXPECT_EQ(verdict(eight(0.1), eight(-2), scale), Verdict::fail);
  EXPECT_EQ(verdict(eight(2), eight(-2), scale), Verdict::same) << "-2 % is as bad as 2 %";
}

TEST(Verdict, AMetricWithAnExpectedValueIsWorseOnEitherSideOfIt) {
  const Gate nees{"nees_position_mean", 30, 0.5};  // 3 expected
  const auto of = [](double middle) {
    Values values;
    for (int i = 0; i < 8; ++i) values.push_back(middle * (1 + 0.01 * i));
    return values;
  };
  EXPECT_EQ(verdict(of(2.69), of(0.96), nees), Verdict::fail) << "under-confident";
  EXPECT_EQ(verdict(of(0.96), of(2.69), nees), Verdict::better);
  EXPECT_EQ(verdict(of(3), of(9), nees), Verdict::fail);
  EXPECT_EQ(verdict(of(9), of(3), nees), Verdict::better);
  EXPECT_EQ(verdict(of(9), of(1), nees), Verdict::same) << "as far above as below";
  EXPECT_EQ(verdict(of(3), of(2.5), nees), Verdict::same);
  EXPECT_EQ(verdict(of(0.3), of(0.03), nees), Verdict::fail) << "less than the absolute tolerance";
  EXPECT_EQ(verdict({2.6, 2.7, 2.8}, {0.9, 1.0, 1.1}, nees), Verdict::fail) << "three seeds suffice";
  // Runs of a perfectly consistent filter: each seed changes by more than the tolerance, but the means do
  // not.
  const Values spread{1.0, 5.8, 2.2, 3.0}, shuffled{5.8, 2.2, 3.0, 1.0};
  EXPECT_EQ(verdict(spread, shuffled, nees), Verdict::same);
  EXPECT_EQ(verdict(spread, {5.8, 4.2, 2.2, 8.1}, nees), Verdict::undecided);
  EXPECT_EQ(verdict({3}, {9}, nees), Verdict::undecided) << "one run shows nothing";
  EXPECT_THAT(judged(results(of(2.69), nees.metric), results(of(0.96), nees.metric), nees).remark,
              HasSubstr("3 expected, off by a factor of 1.08 before, 3.02 now"));
  EXPECT_NEAR(*tolerated_factor(nees), 1.3, 1e-12);
  EXPECT_FALSE(tolerated_factor(kTenPercent));
}

// The median decides. If a seed exceeds the tolerance in the other direction, the change is undecided.
TEST(Verdict, FewSeedsAreJudgedByTheMedianUnlessTheyContradictEachOther) {
  for (const auto& [now, expected] : {std::pair<Values, Verdict>{{1.3, 1.4, 1.5}, Verdict::fail},
                                      {{1.3, 1.4, 1.2}, Verdict::fail},
                                      {{1.3, 1.1, 1.2}, Verdict::same},
                                      {{1.56, 1.72, 0.9}, Verdict::undecided},
                                      {{0.7, 0.8, 1.5}, Verdict::undecided},
                                      {{0.7, 0.8, 1.2}, Verdict::better},
                                      {{1.05, 1.15, 1.2}, Verdict::same}})
    EXPECT_EQ(verdict(kThree, now), expected) << *now[0] << *now[1] << *now[2];
  const MetricVerdict undecided = judged(results(kThree), results({1.56, 1.72, 0.9}));
  EXPECT_FALSE(undecided.p);
  EXPECT_EQ(undecided.remark, "2 of 3 seeds worse beyond tolerance, 1 better");
}

TEST(Verdict, UndecidedCountsAsPassedOnlyIfAllowed) {
  Comparison comparison{"gaitslam", {compare(results(kThree), results({1.56, 1.72, 0.9}), {kTenPercent})}};
  EXPECT_EQ(exit_code(comparison), 1);
  EXPECT_THAT(verdict_table(comparison, false), HasSubstr("0 of 1 row failed, 1 undecided\n"));
  EXPECT_THAT(junit(comparison),
              testing::AllOf(HasSubstr("failures=\"1\""), HasSubstr("<failure message=\"UNDECIDED: ")));
  EXPECT_THAT(github_annotations(comparison), testing::StartsWith("::error "));
  EXPECT_THAT(markdown(comparison), HasSubstr("**UNDECIDED**"));
  comparison.allow_undecided = true;
  EXPECT_EQ(exit_code(comparison), 0);
  EXPECT_THAT(verdict_table(comparison, false), HasSubstr("1 undecided (allowed)\n"));
  EXPECT_THAT(junit(comparison), testing::AllOf(HasSubstr("failures=\"0\" errors=\"0\" skipped=\"1\""),
                                                HasSubstr("<skipped message=\"UNDECIDED: ")));
  EXPECT_THAT(github_annotations(comparison), testing::StartsWith("::warning "));
}

TEST(Verdict, HolmsAdjustmentCoversTheGatesOfOneScenario) {
  ScenarioResults before = results(kEight), now = results(times(1.2, kEight));
  std::vector<Gate> gates{kTenPercent};
  for (const char* other : {"rmse_m", "rpe_1m_m", "rpe_1m_deg", "ate_yaw_rmse_m", "drift_percent"}) {
    for (ScenarioResults* side : {&before, &now})
      for (result::SeedScore& seed : side->seeds)
        seed.metrics.push_back({other, "m", 1.0 + 0.01 * double(seed.seed)});
    gates.push_back({other, 10, 0});
  }
  const ScenarioVerdict verdict = compare(before, now, gates);
  EXPECT_NEAR(*verdict.metrics[0].p, 6 * 2 / 256.0, 1e-15);
  EXPECT_EQ(verdict.metrics[0].verdict, Verdict::fail);  // eight seeds suffice for six gates
  EXPECT_EQ(verdict.metrics[5].verdict, Verdict::identical);
}

// Recorded scores get normal changes, and the first of six gates also a shift in standard deviations of
// these. The table of the README; 0.07 is three standard errors of 500 comparisons.
TEST(Verdict, OneOfSixGatesFindsAShiftAsOftenAsTheTableSays) {
  const Baseline recorded = read_baseline(GAITSLAM_SOURCE_DIR "/scenarios/baselines/ci.json");
  std::vector<Gate> gates = read_suite(GAITSLAM_SOURCE_DIR "/scenarios/suites/ci.yaml").entries[0].gates;
  for (Gate& gate : gates) gate.percent = gate.absolute = 0;
  ASSERT_EQ(gates.size(), 6u);
  sensor_errors::Random random(1, "changes");
  for (const auto& [seeds, sd, found] : {std::tuple(8u, 1.0, 0.26),
                                         {8u, 1.5, 0.57},
                                         {8u, 2.0, 0.83},
                                         {12u, 1.0, 0.55},
                                         {12u, 1.5, 0.93},
                                         {12u, 2.0, 1.0},
                                         {16u, 1.0, 0.79},
                                         {16u, 1.5, 0.99},
                                         {16u, 2.0, 1.0}}) {
    ScenarioResults before = *recorded.find("tangent_circle");
    before.seeds.resize(seeds);
    int failed = 0;
    for (int i = 0; i < 500; ++i) {
      ScenarioResults now = before;
      for (result::SeedScore& seed : now.seeds)
        for (result::SeedMetric& metric : seed.metrics)
          if (metric.value)
            metric.value =
                *metric.value + 1e-3 * (random.normal() + (metric.name == gates[0].metric ? sd : 0));
      failed += compare(before, now, gates).metrics[0].verdict == Verdict::fail;
    }
    EXPECT_NEAR(failed / 500.0, found, 0.07) << seeds << " seeds, " << sd;
  }
}

TEST(Verdict, ValuesThatDisappearAreMissingButNewOnesAreNot) {
  EXPECT_EQ(verdict({1, 2, 3}, {1, {}, 3}), Verdict::missing);
  EXPECT_EQ(verdict({{}, {}, {}}, {1, 2, 3}), Verdict::added);
  EXPECT_EQ(verdict({1, {}, 3}, {1, 2, 3}), Verdict::same);
  ScenarioResults fell = results({{}, {}, {}});
  fell.seeds[0].ending = scenario::Ending::fell;
  fell.seeds[0].cause = "to the left at 3 s";
  const MetricVerdict missing = judged(results({1, 2, 3}), fell);
  EXPECT_EQ(missing.verdict, Verdict::missing);
  EXPECT_EQ(missing.baseline, 2);
  EXPECT_EQ(missing.remark, "3 seeds lost the value: seed 1 fell: to the left at 3 s");
  EXPECT_TRUE(compare(results({1}, "other"), results({1}, "other"), {kTenPercent}).metrics.empty());
  const ScenarioVerdict third = compare(results({1, 2, 3}), results({1, 2, {}}), {kTenPercent});
  EXPECT_EQ(third.metrics[0].worst_seed, 3u) << "the seed whose run has no value";
  EXPECT_THAT(verdict_table({"gaitslam", {third}}, false), HasSubstr("2 of 3 seeds paired (a test needs 8)"));
}

// What the interval says about 0 and what the p-value says agree, for a metric judged by its magnitude too.
TEST(Verdict, TheIntervalOfAChangeExcludesZeroExactlyIfTheTestIsSignificant) {
  std::uint64_t bits = 1;
  int significant = 0;
  for (int i = 0; i < 200; ++i) {
    Values before, now;
    for (int seed = 0; seed < 9; ++seed) {
      const auto draw = [&] {
        return double((bits = bits * 6364136223846793005u + 1442695040888963407u) >> 33);
      };
      before.push_back(2e-9 * draw() - 3);
      now.push_back(2e-9 * draw() - 5);
    }
    const Gate gate{"scale_error_percent", 0, 0};
    const MetricVerdict v = judged(results(before, gate.metric), results(now, gate.metric), gate);
    const auto [low, high] = v.band.value();
    EXPECT_EQ(low > 0 || high < 0, *v.p <= 1 - v.coverage + 1e-12) << low << ' ' << high << ' ' << *v.p;
    significant += *v.p < 0.05;
  }
  EXPECT_GT(significant, 20);
  EXPECT_LT(significant, 180);
}

TEST(Verdict, CommonSeedsArePairedAndDifferentRecordingsOrConfigurationsAreReportedNotJudged) {
  ScenarioVerdict v = compare(results({1, 2, 3, 4}), results({9, 3, 4}, kError, 2), {kTenPercent});
  EXPECT_EQ(v.n_now, 3u);
  EXPECT_EQ(*v.metrics[0].baseline, 3);
  const MetricVerdict other = judged(results(kThree), results({5, 6, 7}, kError, 101));
  EXPECT_EQ(other.verdict, Verdict::added);
  EXPECT_EQ(*other.now, 6);
  EXPECT_EQ(other.remark, "median of 3 seeds: 6");
  EXPECT_EQ(judged(results(kThree), results({})).verdict, Verdict::missing);
  ScenarioResults before = results(kThree), now = results(kThree);
  now.seeds[1].recording = "other";
  before.config = {{"a", "1"}, {"b", "2"}};
  now.config = {{"a", "1"}, {"b", "3"}, {"c", "4"}};
  v = compare(before, now, {kTenPercent});
  EXPECT_EQ(v.other_recordings, 1u);
  EXPECT_THAT(v.other_config, ElementsAre("b: 2 -> 3", "c: not set -> 4"));
  EXPECT_THAT(config_differences({}, {{"slam.gyro.sigma_rad_s", "0.015"}}),
              ElementsAre("slam.gyro.sigma_rad_s: 0.01 (default) -> 0.015"));
  EXPECT_EQ(exit_code({"", {v}}), 0);
}

scenario::Scenario limited(const std::vector<scenario::MetricLimit>& limits, bool filter = true) {
  scenario::Scenario scenario;
  if (filter) scenario.slam.emplace();
  scenario.limits.metrics = limits;
  return scenario;
}
const scenario::MetricLimit kEach{kError, {}, scenario::Bound::at_most, 1.15},
    kMedian{kError, "median", scenario::Bound::at_most, 1.05};

// A seed without a value misses its limit if its scenario has a filter. Otherwise the limit is not judged.
TEST(Verdict, LimitsHoldWhateverTheBaseline) {
  using Observed = std::vector<std::string>;  // for the ending, each seed and the median
  for (const auto& [values, filter, observed, worst_seed] :
       {std::tuple(kThree, true, Observed{"3/3", "2/3", "1.1"}, 3),
        {kThree, false, {"3/3", "2/3", "1.1"}, 3},
        {{1, {}, 1.01}, true, {"3/3", "2/3", "no value for 1 of 3 seeds"}, 2}}) {
    const std::vector<LimitVerdict> limits =
        judge_limits(limited({kEach, kMedian}, filter), results(values).seeds);
    ASSERT_EQ(limits.size(), 3u);
    EXPECT_EQ(limits[0].what, "ending completed");
    for (const std::size_t i : {0u, 1u, 2u}) {
      EXPECT_EQ(limits[i].observed, observed[i]);
      EXPECT_EQ(limits[i].state, i == 0 ? LimitState::met : LimitState::missed);
      EXPECT_EQ(limits[i].worst_seed, i == 0 ? std::nullopt : std::optional<std::uint64_t>(worst_seed));
    }
    EXPECT_EQ(exit_code({"", {ScenarioVerdict{"", 3, 3, 0, {}, {}, limits}}}), 1);
  }
  EXPECT_EQ(judge_limits(limited({kEach}, false), results({{}, {}}).seeds).size(), 1u) << "only the endings";
  ScenarioResults runs = results(kThree);
  runs.seeds[1].ending = scenario::Ending::fell;
  const std::vector<LimitVerdict> limits = judge_limits(limited({kEach}), runs.seeds);
  EXPECT_EQ(limits[0].state, LimitState::run_failed);
  EXPECT_EQ(limits[0].worst_seed, 2u);
  EXPECT_THAT(limits[0].failures, ElementsAre("seed 2 fell"));
  EXPECT_EQ(exit_code({"", {ScenarioVerdict{"", 3, 3, 0, {}, {}, limits}}}), 3);
}

TEST(Verdict, ATracebackOfSeveralSeedsIsShownOnce) {
  ScenarioResults runs = results({{}, {}, {}});
  for (result::SeedScore& seed : runs.seeds) {
    seed.ending = scenario::Ending::estimator_failed;
    seed.cause = "it ended; its last lines: Traceback";
    seed.last_lines =
        fmt::format("at {}\n{}", seed.seed, seed.seed == 3 ? "KeyError: 1" : "ZeroDivisionError");
  }
  EXPECT_THAT(judge_limits(limited({}), runs.seeds)[0].failures,
              ElementsAre(HasSubstr("at 1"), "seed 2 estimator_failed: it ended", HasSubstr("KeyError")));
}

TEST(Verdict, ALimitOnNeesIsJudgedOnTheMeanOverSeedsWithItsInterval) {
  const std::string nees = "nees_position_mean";
  for (const auto& [values, state] : {std::pair<Values, LimitState>{{1.0, 5.8, 2.2, 3.0}, LimitState::met},
                                      {{1.0, 9.8, 2.2, 6.0}, LimitState::undecided},
                                      {{8.0, 9.8, 8.2, 9.0}, LimitState::missed},
                                      {{5.8}, LimitState::missed},
                                      {{1.0, {}}, LimitState::missed}}) {
    const auto limits =
        judge_limits(limited({{nees, {}, scenario::Bound::at_most, 4}}), results(values, nees).seeds);
    EXPECT_EQ(limits.at(1).state, state) << limits[1].observed;
  }
  EXPECT_EQ(judge_limits(limited({{nees, {}, scenario::Bound::at_most, 4}}),
                         results({1.0, 5.8, 2.2, 3.0}, nees).seeds)[1]
                .observed,
            "3 [-0.245, 6.25]");
}

// Draws the means over n seeds of the NEES of runs whose errors persist, and expects 95 % in the band.
TEST(Consistency, AConsistentFilterIsInTheBandAndNoisesFourTimesTooLargeOrSmallAreNot) {
  const auto state = [](const std::string& metric, const Values& values, double factor = 1) {
    ScenarioResults all = results(values, metric);
    for (result::SeedScore& seed : all.seeds) seed.metrics.push_back({"true_poses", "1", 1000});
    return judge_consistency(all.seeds, factor).at(0).state;
  };
  sensor_errors::Random random(7, "test");
  const auto run = [&] {  // by chi-square at 10 independent seconds instead of a random walk
    double sum = 0;
    for (int i = 0; i < 30; ++i) sum += std::pow(random.normal(), 2);
    return sum / 10;
  };
  int in = 0;
  for (int i = 0; i < 100; ++i) {
    Values nees(16);
    std::ranges::generate(nees, run);
    in += state("nees_position_mean", nees) == LimitState::met;
    if (i == 0) {
      EXPECT_EQ(state("nees_position_mean", times(16, nees), 1.5), LimitState::missed);
      EXPECT_EQ(state("nees_position_mean", times(1 / 16., nees), 1.5), LimitState::missed);
    }
  }
  EXPECT_GE(in, 95);
  for (const double nis : {0.05, 8.0})
    EXPECT_EQ(state("nis_vision_mean", Values(16, nis), 1.5), LimitState::missed);
  EXPECT_EQ(state("nis_vision_mean", Values(16, 0.55), 1.5), LimitState::met);
  EXPECT_EQ(state("nis_vision_mean", Values(3, 1.1)), LimitState::missed) << "3000 innovations: 0.95 to 1.05";
  EXPECT_TRUE(judge_consistency(results({1, 2}).seeds, 1).empty());
}

TEST(Verdict, WhereMissedLimitsAreExpectedEverySeedMustMissOne) {
  const auto judged = [&](const Values& values) {
    const scenario::MetricLimit limit{kError, {}, scenario::Bound::at_most, 1.05};
    return judge_limits(limited({limit}), results(values).seeds, true).at(1);
  };
  EXPECT_EQ(judged(kThree).state, LimitState::missed);
  EXPECT_EQ(judged(kThree).observed, "2/3");
  EXPECT_EQ(judged(kThree).worst_seed, 1u);
  EXPECT_EQ(judged({1.1, {}, 1.2}).state, LimitState::met);
}

Comparison comparison() {
  ScenarioVerdict walk;
  walk.name = "tangent_circle";
  walk.n_baseline = walk.n_now = 10;
  const Gate ate{"ate_se3_rmse_m", 10, 0.001};
  walk.metrics = {{ate, 10, 0.041, 0.052, 0.011, std::pair(0.008, 0.02), 0.961, 0.004, Verdict::fail, "", 7},
                  {{"loop_landmarks", 0, 2}, 10, 18, 18, 0, {}, 0, {}, Verdict::identical, "", 1},
                  {{"rmse_m", 5, 0}, 10, {}, 1.0, {}, {}, 0, {}, Verdict::added, "", 1}};
  walk.limits = {{"loop_closed.worst >= 1", "0", LimitState::missed, 3},
                 {"ending completed",
                  "9/10",
                  LimitState::run_failed,
                  4,
                  {"seed 4 fell: to the left\nits last lines:\na | b"}},
                 {"rmse_m <= 1", "10/10", LimitState::met, {}}};
  walk.wall_s = 12.5;
  walk.file = "scenarios/tangent_circle.yaml";
  walk.repro = [](std::uint64_t seed) {
    return "tools/gaitslam run scenarios/tangent_circle.yaml seed=" + std::to_string(seed);
  };
  return {"a title, with 5 % & more", {walk}};
}

TEST(VerdictTable, FitsEightyColumnsAndHasACommandForEachFailure) {
  const std::string text = verdict_table(comparison(), false);
  for (const std::string& line : files::lines_of(text)) EXPECT_LE(line.size(), 80u) << line;
  EXPECT_THAT(text, testing::ContainsRegex(
                        "ate_se3_rmse_m +0.041 +\\+27 % +\\[\\+20,\\+49\\] +96.1 % +0.004  FAIL\n"));
  EXPECT_THAT(text, HasSubstr("tolerance 10 % or 0.001 m; worst seed 7\n"));
  EXPECT_THAT(text, HasSubstr("  again:\n    tools/gaitslam run scenarios/tangent_circle.yaml seed=7\n"));
  EXPECT_THAT(text, testing::ContainsRegex("loop_landmarks +18 +0 % +- +- +-  IDENTICAL\n"));
  EXPECT_THAT(text, testing::ContainsRegex("limit ending completed +9/10  RUN FAILED\n"));
  EXPECT_THAT(text, HasSubstr("tangent_circle.yaml seed=4\n"));
  EXPECT_THAT(text, HasSubstr("\n3 of 6 rows failed\n"));
  EXPECT_THAT(text, Not(HasSubstr("\033")));
  EXPECT_THAT(verdict_table(comparison(), true), HasSubstr("\033[31mFAIL\033[0m"));
}

TEST(VerdictReports, JunitHasFailuresErrorsAndSkips) {
  EXPECT_THAT(
      junit(comparison()),
      testing::AllOf(
          HasSubstr(
              "<testsuite name=\"a title, with 5 % &amp; more\" tests=\"6\" failures=\"2\" errors=\"1\" "
              "skipped=\"1\" time=\"12.500\">"),
          HasSubstr("<testcase classname=\"tangent_circle\" name=\"ate_se3_rmse_m\" time=\"12.500\"><failure "
                    "message=\"FAIL: 0.041 m changes by +27 % (tolerance 10 % or 0.001 "
                    "m)\">tools/gaitslam run"),
          HasSubstr("name=\"limit ending completed\" time=\"0.000\"><error message=\"RUN FAILED: observed: "
                    "9/10; seed 4 fell: to the left\">tools/gaitslam run"),
          HasSubstr("seed 4 fell: to the left&#10;its last lines:&#10;a | b</error>"),
          HasSubstr("<skipped message=\"NEW: none -&gt; 1 m (tolerance 5 %)\"/></testcase>")));
  EXPECT_THAT(junit(comparison()), Not(HasSubstr("</failure><system-out>")));
}

TEST(VerdictReports, AnnotationsMarkdownAndJsonHaveTheirRowsEscaped) {
  const std::string text = github_annotations(comparison());
  EXPECT_THAT(text, testing::StartsWith("::error file=scenarios/tangent_circle.yaml,title=tangent_circle "
                                        "ate_se3_rmse_m%3A FAIL::0.041 m changes by +27 %25 (tolerance"));
  EXPECT_EQ(std::ranges::count(text, '\n'), 3);
  EXPECT_THAT(markdown(comparison()),
              testing::AllOf(HasSubstr("| `ate_se3_rmse_m` | **FAIL** | 0.041 m changes by +27 %"),
                             HasSubstr("| `limit rmse_m <= 1` | ok | observed: 10/10 |\n"),
                             HasSubstr("observed: 9/10; seed 4 fell: to the left<br>`tools/gaitslam run"),
                             HasSubstr("<br>`its last lines:`<br>`a \\| b` |\n")));
  const auto json = nlohmann::json::parse(verdicts_json(comparison())), walk = json["scenarios"][0];
  EXPECT_EQ(json["exit_code"], 3);
  EXPECT_EQ(walk["metrics"][0]["verdict"], "FAIL");
  EXPECT_EQ(walk["metrics"][0]["change_interval"][1], 0.02);
  EXPECT_TRUE(walk["metrics"][2]["baseline"].is_null());
  EXPECT_EQ(walk["limits"].size(), 3u);
  EXPECT_EQ(walk["wall_s"], 12.5);
}

// Names, reasons and commands from users: every format stays well-formed, and no text leaves its cell.
TEST(VerdictReports, ForeignTextBecomesNeitherMarkupNorControlCharacters) {
  const std::string wild = "\x1b[31m \xe9 \xed\xa0\x80 \xef\xbf\xbe a|b `c` <d> &e\r\nf\t*g* [h](i) \\|";
  Comparison comparison{"gaitslam " + wild, {compare(results(kThree), results({9, 9, 9}), {kTenPercent})}};
  ScenarioVerdict& walk = comparison.scenarios[0];
  walk.name = walk.file = wild;
  walk.metrics[0].remark = wild;
  walk.limits = {{wild, wild, LimitState::run_failed, 1, {wild}}};
  walk.other_config = {wild};
  walk.repro = [&](std::uint64_t) { return wild; };
  const std::string table = markdown(comparison), annotations = github_annotations(comparison);
  for (const std::string& text : {verdict_table(comparison, false), junit(comparison), table, annotations})
    EXPECT_EQ(files::sanitize(text), text);
  EXPECT_EQ(files::sanitize(nlohmann::json::parse(verdicts_json(comparison)).dump()).find('\x1b'),
            std::string::npos);
  EXPECT_THAT(junit(comparison),
              testing::AllOf(HasSubstr("a|b `c` &lt;d&gt; &amp;e?&#10;f&#9;*g*"), Not(HasSubstr("<d>"))));
  EXPECT_EQ(std::ranges::count(annotations, '\n'), 2);
  EXPECT_THAT(table, testing::AllOf(HasSubstr("a\\|b \\`c\\` &lt;d> &amp;e? f \\*g\\* \\[h](i) \\\\\\|"),
                                    Not(HasSubstr("`c`"))));
  for (const std::string& line : files::lines_of(table.substr(table.find("| metric")))) {
    int bars = 0;
    for (std::size_t i = 0; i < line.size(); ++i)
      if (line[i] == '\\')
        ++i;
      else
        bars += line[i] == '|';
    EXPECT_EQ(bars, 4) << line;
  }
}

}  // namespace
}  // namespace sim::regression
