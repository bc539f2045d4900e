// The files of a result, its limits, and the summary over seeds.
#include "sim/result/result.h"

#include "sim/files/csv.h"
#include "sim/result/job_log.h"
#include "sim/result/limits.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::result {
namespace {

using scenario::Bound, scenario::MetricLimit, testing::HasSubstr, testing::Not, testing::AllOf;

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

std::vector<SeedScore> seeds_of(const std::string& metric, const std::vector<double>& values) {
  std::vector<SeedScore> seeds;
  for (const double value : values)
    seeds.push_back({seeds.size() + 1, scenario::Ending::completed, 0, {{metric, "1", value}}});
  return seeds;
}

TEST(Summary, AggregatesCoverOnlyTheSeedsThatHaveTheMetric) {
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

TEST(Summary, TheWorstIsOnTheSideOfTheLimitOrElseFollowsTheMetricsDefinition) {
  const auto worst = [](const std::string& metric, const std::vector<double>& values,
                        std::vector<MetricLimit> limits = {}) {
    return summarize(limited(std::move(limits)), seeds_of(metric, values)).metrics[0].over_seeds.worst;
  };
  EXPECT_EQ(worst(kAte, {-0.3, 0.1}, {{kAte, {}, Bound::at_least, 1}}), -0.3);
  EXPECT_EQ(worst("loop_closed", {0, 1}, {{"loop_closed", {}, Bound::at_most, 1}}), 1);
  EXPECT_EQ(worst("loop_landmarks", {12, 18, 15}), 12);  // few landmarks are bad
  EXPECT_EQ(worst(kAte, {0.1, 0.4, 0.2}), 0.4);
  EXPECT_EQ(worst("scale_error_percent", {0.5, -2, 1}), -2);  // an error of either sign is bad
  // A tenth of the expected value is worse than twice that value.
  EXPECT_EQ(worst("nees_position_mean", {2.5, 0.3, 6}), 0.3);
  EXPECT_EQ(worst("nis_gyro_mean", {0.9, 3, 0.4}), 3);
  EXPECT_EQ(worst("a metric of another program", {-3, 2}), 2);
}

TEST(Summary, TheTableShowsHeadlineMetricsFirstAndAllOnRequest) {
  SeedScore one = seed(1, 0.1, 1);
  one.metrics.insert(one.metrics.begin(), {"poses_matched", "1", 100});
  SeedScore other = one;
  other.seed = 2, other.exit_code = 1;
  const Summary summary = summarize(limited({}), {one, other});
  const std::string some = summary_table(summary),
                    all = summary_table(summary, {.colors = true, .all_metrics = true});
  EXPECT_THAT(some, AllOf(Not(HasSubstr("poses_matched")), HasSubstr("--all-metrics"),
                          HasSubstr("walk, 2 seeds\n  passed          completed         seed 1\n"
                                    "  missed a limit  completed         seed 2\n")));
  EXPECT_LT(all.find(kAte), all.find("poses_matched"));
  EXPECT_THAT(all, AllOf(HasSubstr("poses_matched"), HasSubstr("\033[31mmissed a limit\033[0m")));
  EXPECT_THAT(summary_table(summarize(limited({{"poses_matched", {}, Bound::at_least, 1}}), {one})),
              HasSubstr("poses_matched"))
      << "there is a limit on it";
  EXPECT_THAT(summary_table(summarize(limited({}), {seed(1, 0.1, 1)})),
              AllOf(HasSubstr("walk, 1 seed\n"), HasSubstr("0.1        0.1          -        0.1\n")));
  EXPECT_THAT(summary_table(summarize(limited({}), {{1, scenario::Ending::crashed, 3, {}}})),
              AllOf(HasSubstr("no metrics: no seed has a score\n"), Not(HasSubstr("median"))));
}

TEST(Summary, TheExitCodeIsTheWorstSeedsOrThatOfAMissedLimitOverSeeds) {
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

TEST(Summary, ALimitOverSeedsIsMissedIfOneSeedHasNoValue) {
  const MetricLimit median{kAte, "median", Bound::at_most, 1};
  EXPECT_EQ(exit_code(summarize(limited({median}), {seed(1, {}, 1)})), 1);
  EXPECT_EQ(exit_code(summarize(limited({median}, false), {seed(1, {}, 1)})), 0) << "no filter was requested";
  for (const bool filter : {true, false}) {  // without a filter: a metric of the walk itself
    const Summary summary =
        summarize(limited({median}, filter), {seed(1, 0.1, 1), seed(2, {}, 1), seed(3, {}, 1)});
    EXPECT_EQ(exit_code(summary), 1);
    EXPECT_THAT(summary_table(summary),
                HasSubstr("limit ate_se3_rmse_m.median at_most 1: -  MISSED: no value for 2 of 3 seeds\n"));
    EXPECT_EQ(to_json(summary)["limits"][0].dump(),
              R"({"metric":"ate_se3_rmse_m.median","at_most":1.0,"value":null,"passed":false,)"
              R"("reason":"no value for 2 of 3 seeds"})");
  }
}

TEST(Summary, ARunWithoutAScoreCrashedOrWasNotStarted) {
  EXPECT_EQ(without_score(1, 3).ending, scenario::Ending::crashed);
  EXPECT_EQ(without_score(1, 2).ending, scenario::Ending::not_started);
}

TEST(Summary, TheFileContainsEverythingUnderItsOwnName) {
  const files::TemporaryFolder root;
  write_summary(root / "summary.json", summarize(limited({{kAte, "median", Bound::at_most, 0.2}}),
                                                 {seed(1, 0.1, {}), seed(2, 0.3, {}, 1)}));
  const auto json = nlohmann::json::parse(files::read_text(root / "summary.json"));
  EXPECT_EQ(json["seeds"][1]["exit_code"], 1);
  EXPECT_EQ(json["metrics"][kAte]["n"], 2);
  EXPECT_EQ(json["metrics"][kAte]["worst"], 0.3);
  EXPECT_TRUE(json["metrics"]["loop_closed"]["sd"].is_null());
  EXPECT_EQ(json["limits"][0].dump(),
            R"({"at_most":0.2,"metric":"ate_se3_rmse_m.median","passed":true,"value":0.2})");
}

TEST(Limits, AMissedLimitGivesExitCodeOneAndAForbiddenEndingThree) {
  using enum scenario::Ending;
  const MetricLimit error{"rmse_m", {}, Bound::at_most, 0.1},
      landmarks{"loop_landmarks", {}, Bound::at_least, 3}, median{"rmse_m", "median", Bound::at_most, 0.1};
  for (const auto& [limit, value, code, ending, filter] :
       std::vector<std::tuple<MetricLimit, std::optional<double>, int, scenario::Ending, bool>>{
           {error, 0.1, 0, completed, true},
           {error, 0.2, 1, completed, true},
           {landmarks, 3, 0, completed, true},
           {landmarks, 2, 1, completed, true},
           {error, 0.2, 1, diverged, true},
           {error, 0.1, 3, fell, true},
           {median, 0.2, 0, completed, true},
           {error, {}, 1, completed, true},
           {error, {}, 0, completed, false},
           {error, 0.2, 1, completed, false}}) {
    const scenario::Scenario scenario = limited({limit}, filter);
    const auto judged = judge_run(scenario, [&, &value = value](const std::string&) { return value; });
    EXPECT_EQ(exit_code(scenario, ending, judged), code) << limit.metric << value.value_or(-1);
  }
  EXPECT_TRUE(to_json(judge(limited({}, false), median, {})).at("passed").is_null());
}

constexpr const char* kScore = R"({"scenario": "walk", "seed": 3, "ending": "completed", "exit_code": 1,
  "metrics": {"rmse_m": {"value": 0.25, "unit": "m"}, "loop_closed": {"value": null, "unit": "1", "reason": "no loop"}},
  "limits": [{"metric": "rmse_m", "at_most": 0.5, "value": 0.25, "passed": true}]})";
constexpr const char* kTiming =
    R"({"frame_cpu_ms_median": 0.5, "frame_cpu_ms_p99": 1, "realtime_factor": 2})";

class ScoreFile : public testing::Test {
 protected:
  ScoreFile() { files::write_text(folder_ / "timing.json", kTiming); }
  std::string table(const std::string& from = "", const std::string& to = "") const {
    std::string text = kScore;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    files::write_text(folder_ / "score.json", text);
    return score_table(folder_.path());
  }
  const files::TemporaryFolder folder_;
};

TEST_F(ScoreFile, TheTableShowsMetricsWithTheirLimitsAndAllOnRequest) {
  const std::string from = "\"metrics\": {", to = from + R"("poses_matched": {"value": 7, "unit": "1"},)";
  EXPECT_THAT(table(from, to),
              AllOf(HasSubstr("walk  seed 3  completed\n"), HasSubstr("0.2500 m     <= 0.5000  ok"),
                    HasSubstr("filter 0.500 ms CPU per frame"), Not(HasSubstr("  poses_matched")),
                    Not(HasSubstr("\033"))));
  EXPECT_EQ(read_score(folder_ / "score.json").value("rmse_m"), 0.25);
  EXPECT_FALSE(read_score(folder_ / "score.json").value("loop_closed"));
  EXPECT_THAT(score_table(folder_.path(), {.all_metrics = true}),
              testing::ContainsRegex("  poses_matched +7\n"));
  EXPECT_THAT(score_table(folder_.path(), {.colors = true}, true), HasSubstr("\033[31mcompleted\033[0m"));
  EXPECT_THAT(table("\"value\": 0.25, \"unit\": \"m\"", R"("value": 0.25, "unit": "m", "note": "at 3.4 s")"),
              HasSubstr("<= 0.5000  ok  at 3.4 s\n"));
}

TEST_F(ScoreFile, ValuesAndLimitsHaveEnoughDigitsToDifferFromZeroAndFromEachOther) {
  EXPECT_THAT(table("\"at_most\": 0.5", "\"at_most\": 1e-6"), HasSubstr("0.2500 m     <= 1e-06  ok"));
  EXPECT_THAT(table("0.25, \"unit\"", "0.0000123, \"unit\""), HasSubstr(" 1.23e-05 m     <= 0.5000  ok"));
  EXPECT_THAT(table("0.25, \"unit\"", "0.500004, \"unit\""), HasSubstr(" 0.500004 m     <= 0.500000  ok"));
}

TEST_F(ScoreFile, AReasonSharedByMetricsAppearsOnce) {
  const std::string other =
      R"("loop_time_s": {"value": null, "unit": "s", "reason": "no loop"}, "loop_closed")";
  const std::string text = table("\"loop_closed\"", other);
  EXPECT_EQ(text.find("no loop"), text.rfind("no loop")) << text;
  EXPECT_THAT(text, testing::ContainsRegex("loop_time_s +- s +\\(1\\)\n"));
  EXPECT_THAT(text, testing::ContainsRegex("loop_closed +- +\\(1\\)\n  \\(1\\) no loop\n"));
  EXPECT_THAT(table(), testing::ContainsRegex("loop_closed +- +no loop\n"))
      << "a single reason is next to its metric";
}

TEST_F(ScoreFile, TheTableStatesACauseTheCoverageAndTheAlignmentOfATrajectory) {
  files::write_text(folder_ / "about.json", R"({"cause": "left hand and desk at 3.2 s"})");
  EXPECT_THAT(table("completed", "collided"), HasSubstr("collided: left hand and desk at 3.2 s\n"));
  EXPECT_THAT(table(), Not(HasSubstr("left hand")));
  EXPECT_THAT(score_table(folder_.path(), {}, true), Not(HasSubstr("left hand")));
  const std::string metrics = "\"metrics\": {",
                    poses = metrics + R"("poses_matched": {"value": 7, "unit": "1"},
    "true_poses": {"value": 35, "unit": "1"}, "tracked_fraction": {"value": 0.2, "unit": "1"},)";
  EXPECT_THAT(table(metrics, poses),
              HasSubstr("7 of 35 true poses matched (stamps within 0.1 ms), tracked 20 % of the time\n"
                        "  errors without alignment except ate_se3"));
  files::write_text(folder_ / "about.json", R"({"alignment": "sim3"})");
  EXPECT_THAT(table(metrics, poses), HasSubstr("errors after sim3 alignment with the truth"));
}

TEST_F(ScoreFile, DetailsContainTheCauseAndTheLastLinesOfTheLog) {
  std::string log;
  for (int i = 1; i <= 9; ++i) log += "line " + std::to_string(i) + "\n";
  files::write_text(folder_ / "about.json", R"({"cause": "killed"})");
  table();
  files::write_text(folder_ / "timing.json", R"({"wall_s": 2.5})");
  for (const auto& [text, last] : {std::pair(log, log.substr(log.find("line 5"))),
                                   {"one", "one"},
                                   {"10 %\r\x1b[31mfailed\xed\xa0\x80\n", "10 %\n?[31mfailed???\n"}}) {
    files::write_text(folder_ / "estimator.log", text);
    const SeedScore score = read_result(folder_.path());
    EXPECT_EQ(score.exit_code, 1);
    EXPECT_EQ(score.cause, "killed");
    EXPECT_EQ(score.wall_s, 2.5);
    EXPECT_EQ(score.last_lines, last);
  }
}

TEST_F(ScoreFile, AWrongTypeIsReportedWithItsKey) {
  for (const auto& [from, to, complaint] : std::vector<std::array<std::string, 3>>{
           {"\"completed\"", "\"done\"", "ending: is 'done', expected one of completed, fell"},
           {"0.25, \"unit\"", "\"0.25\", \"unit\"", "metrics.rmse_m.value: expected a number, found string"},
           {"[{", "{\"a\": [{", ": is not JSON or is cut off here"},
           {"\"limits\"", R"("tracking": {"suspect": [{"from_s": "x", "cause": ""}]}, "limits")",
            "tracking.suspect[0].from_s: expected a number"}})
    EXPECT_THAT(files::error_of([&, from = from, to = to] { table(from, to); }), HasSubstr(complaint)) << to;
}

TEST_F(ScoreFile, MissingEntriesOfAboutAreEmptyAndAWrongTypeIsReportedWithItsKey) {
  const auto read = [&](const std::string& text) {
    files::write_text(folder_ / "about.json", text);
    return read_about(folder_ / "about.json");
  };
  const About about = read(R"({"walk_ending": "fell", "seed": 3, "set_by": {"seed": "argument 1"}})");
  ASSERT_TRUE(about.walk);
  EXPECT_EQ(about.walk->ending, scenario::Ending::fell);
  EXPECT_EQ(about.seed, 3u);
  EXPECT_EQ(about.set_by.at("seed"), "argument 1");
  EXPECT_EQ(about.program, "");
  EXPECT_THAT(files::error_of([&] { read("{}"), read_about_of_walk(folder_ / "about.json"); }),
              HasSubstr("about.json: walk_ending: is missing"));
  EXPECT_THAT(files::error_of([&] { read(R"({"set_by": {"seed": 1}})"); }),
              HasSubstr("about.json: set_by.seed: expected text, found number"));
}

TEST(TrackedFiles, TextsOfAFrameRoundTrip) {
  const std::string cause = " too long by 9, it reads \"no\", twice\x01\t";
  tracking::Tracked tracked;
  slam::FrameReport& report = tracked.frames.emplace_back().report;
  report.health = slam::Health::lost;
  report.cause = cause, report.refused.add("gyro, " + cause), report.suspect = "\"";
  const files::TemporaryFolder folder;
  write_tracked(folder.path(), tracked);
  files::CsvReader rows(folder / "frames.csv");
  ASSERT_TRUE(rows.next());
  const std::size_t n = rows.fields();
  for (std::size_t i = 0;
       const std::string& text : {std::string("lost"), cause, "gyro, " + cause, std::string("\"")})
    EXPECT_EQ(rows.text(n - 4 + i++), text);
  EXPECT_FALSE(rows.next());
}

JobRecord record(int i) {
  return {"key-" + std::to_string(i), std::uint64_t(i), "completed", "", {{"rmse_m", 0.1 * i}}};
}

TEST(JobLog, ARecordIsReadBackBitForBit) {
  JobRecord odd{"k", 18446744073709551615u, "diverged", "lost at 3 s: \"dark\"\nand so on", {}};
  odd.values = {{"third", 1.0 / 3},
                {"tiny", std::numeric_limits<double>::denorm_min()},
                {"most", std::numeric_limits<double>::max()},
                {"minus_zero", -0.0}};
  const auto back = from_line(to_line(odd));
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, odd);
  EXPECT_TRUE(std::signbit(back->values.at("minus_zero")));
  EXPECT_EQ(to_line(odd).find('\n'), std::string::npos);
}

TEST(JobLog, KeysShowWhereEachPartEnds) {
  EXPECT_NE(job_key({"ab", "c"}), job_key({"a", "bc"}));
  EXPECT_NE(job_key({"a", ""}), job_key({"a"}));
  EXPECT_EQ(job_key({"a", "b"}), job_key({"a", "b"}));
}

TEST(JobLog, WhereverItIsCutOffCompleteLinesAreKeptAndTheRestIsWrittenAgain) {
  const files::TemporaryFolder folder;
  const auto file = folder / "trials.jsonl";
  {
    JobLog log(file, "a sweep");
    log.add({record(0), record(1)});
    log.add({{"key-1", 1, "fell", "twice", {}}, record(2)});
  }
  EXPECT_EQ(*JobLog(file, "a sweep").find("key-1"), record(1));
  const std::string whole = files::read_text(file);
  const auto continued = [&](const std::string& left) {
    files::write_text(file, left);
    JobLog log(file, "a sweep");
    log.add({record(0), record(1), record(2)});
    return files::read_text(file);
  };
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes)
    EXPECT_EQ(continued(whole.substr(0, bytes)), whole) << "cut after " << bytes << " bytes";
  for (const char* key : {"key-0", "key-2"}) {  // as left by a power failure
    std::string torn = whole;
    torn.replace(torn.find(key), 5, 5, '\0');
    EXPECT_EQ(continued(torn), whole) << key;
  }
  EXPECT_THAT(files::error_of([&] { JobLog(file, "another sweep"); }),
              testing::HasSubstr("is another log: a sweep, expected another sweep"));
}

}  // namespace
}  // namespace sim::result
