// Tables, pages and their rows.
#include "sim/pages/pages.h"

#include <nlohmann/json.hpp>

#include "sim/files/hash.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::pages {
namespace {

using namespace testing;
using nlohmann::json, tests::Has, tests::Lacks;

constexpr const char* kPayload = R"(</title></script><img src=x onerror='a()'>"<!--&)";
constexpr const char* kShown =
    "&lt;/title&gt;&lt;/script&gt;&lt;img src=x onerror=&#39;a()&#39;&gt;&quot;&lt;!--&amp;";

TEST(Html, TextIsShownLiterallyInElementsAndAttributes) {
  EXPECT_EQ(escaped(kPayload), kShown);
  EXPECT_EQ(escaped("ATE of 5 mm, 3 \xcf\x83"), "ATE of 5 mm, 3 \xcf\x83");
}

TEST(Html, ThePolicyAllowsTheScriptByItsHashAndNothingElse) {
  // The example of the specification of Content Security Policies, level 3, section 8.3.
  EXPECT_EQ(base64(files::sha256("alert('Hello, world.');")), "qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng=");
  const std::string page = html_page("a", "", ""), tag = "<script>";
  const std::size_t begin = page.rfind(tag) + tag.size();
  const std::string script = page.substr(begin, page.rfind("</script>") - begin);
  EXPECT_THAT(page, AllOf(Has("script-src 'sha256-" + base64(files::sha256(script)) + "';",
                              "default-src 'none';", "base-uri 'none'; form-action 'none'"),
                          Lacks("script-src 'unsafe-inline'")));
  EXPECT_LT(page.find("Content-Security-Policy"), page.find("<title>"))
      << "it applies to everything after it";
}

TEST(Html, Base64GivesTheTestVectorsOfRfc4648) {
  for (const auto& [bytes, text] : {std::pair{"", ""}, {"f", "Zg=="}, {"fo", "Zm8="}, {"foobar", "Zm9vYmFy"}})
    EXPECT_EQ(base64(bytes), text);
}

std::string without_scripts(const std::string& page) { return page.substr(0, page.find("<script>")); }

void expect_harmless(const std::string& page) {
  EXPECT_THAT(without_scripts(page), AllOf(Has("Content-Security-Policy", kShown), Lacks("<img", "<script")));
}

class ReceivedTuning : public testing::Test {
 protected:
  ReceivedTuning() {
    const json sides{{"start", {1, 2}}, {"best", {1, nullptr}}};
    json side{{"runs", {kPayload, kPayload}}};
    for (const char* name : {kPayload, "nees_position_mean", "nees_orientation_mean"})
      side["values"][name] = sides;
    json parameter = json::parse(R"({"from": 1, "to": 2, "scale": "log", "start": 1, "best": 2})");
    parameter["key"] = parameter["unit"] = tuning_["name"] = tuning_["objective"] = kPayload;
    tuning_["accepted"] = true;
    tuning_["change"] = {{"verdict", "better"}, {"text", kPayload}};
    tuning_["parameters"] = json::array({parameter});
    tuning_["training"] = tuning_["holdout"] = side;
  }
  /// history: its columns after the origin, and its rows.
  std::string page(const std::string& history = kPayload + std::string(",") + kPayload +
                                                "2\n0,a,1.5,3\n1,a,1.2,2\n") const {
    std::ofstream(folder_ / "tune.json") << tuning_.dump();
    std::ofstream(folder_ / "history.csv") << "#setting,origin," << history;
    return tune_page(folder_.path());
  }
  json tuning_;
  const files::TemporaryFolder folder_;
};

TEST_F(ReceivedTuning, NamesAreShownLiterallyAndRunsBeforeAndAfterWithTheirMeans) {
  EXPECT_THAT(page(), Has("<td>nees_<wbr>position_<wbr>mean</td><td class='number'>1.5</td><td "
                          "class='number'>1</td><td class='number'>-</td>"
                          "<td class='number'>1 → 1</td><td class='number'>2 → -</td></tr>"));
  tuning_["objective"] = std::string(kPayload) + "2";
  for (const char* side : {"training", "holdout"})
    tuning_[side]["values"][std::string(kPayload) + "2"] = tuning_[side]["values"][kPayload];
  expect_harmless(page());
}

TEST_F(ReceivedTuning, EverySettingIsDrawnAlsoAboveTheFigure) {
  tuning_["objective"] = "loss";
  std::string rows = fmt::format("loss,{}\n", kPayload);
  for (const char* const loss : {"1.5", "1.2", "1.1", "900", "1.3", "nan"})
    rows += fmt::format("0,a,{},1\n", loss);
  const std::string html = page(rows);
  EXPECT_THAT(html, Has("2 of 6 above"));
  const std::size_t history = html.find("data-figure='history'");
  const std::string figure = html.substr(history, html.find("</figure>", history) - history);
  std::size_t dots = 0;
  for (std::size_t at = 0; (at = figure.find("h0", at)) != figure.npos; ++at) ++dots;
  EXPECT_EQ(dots, 6u);
}

TEST_F(ReceivedTuning, TheParameterThatMattersIsImportantAndTheGainHasAnInterval) {
  tuning_["objective"] = "loss";
  for (const char* const key : {"matters", "idle"})
    tuning_["parameters"].push_back(tuning_["parameters"][0]), tuning_["parameters"].back()["key"] = key;
  tuning_["holdout"]["values"] = {{"rmse_m", {{"start", {1.0, 2.0}}, {"best", {0.5, 1.3}}}}};
  std::string history = fmt::format("loss,{},matters,idle\n", kPayload);
  for (int i = 0; i < 48; ++i) history += fmt::format("{},a,{},1,{},{}\n", i, i % 8, i % 8, i * 7 % 48);
  const std::string html = page(history);
  const auto importance = [&](const std::string& key) {
    const std::size_t row = html.find("<tr><td>" + key), end = html.find("</td></tr>", row);
    return std::stod(html.substr(html.rfind('>', end) + 1));
  };
  EXPECT_GT(importance("matters"), 0.9);
  EXPECT_LT(importance("idle"), 0.2);
  EXPECT_THAT(html, Has("<td>rmse_<wbr>m [m]</td><td class='number'>1.5</td><td class='number'>0.9</td>"
                        "<td class='number'>-0.6 [-1.871, 0.6706]</td><td class='number'>1 → 0.5</td>"));
}

TEST_F(ReceivedTuning, OnlyBetterAndWorseHaveAColor) {
  EXPECT_THAT(page(), Has("<span class='verdict good'>better</span>"));
  tuning_["accepted"] = false;
  for (const auto& [verdict, color] : {std::pair{"worse", "bad"}, {"undecided", ""}, {"unchanged", ""}}) {
    tuning_["change"]["verdict"] = verdict;
    EXPECT_THAT(page(), Has(fmt::format("<span class='verdict {}'>{}</span>", color, verdict)));
  }
}

TEST_F(ReceivedTuning, SettingsWithTheLowestLossesStandOutInTheFiguresOfSeveralParameters) {
  tuning_["objective"] = "loss";
  tuning_["parameters"].push_back(tuning_["parameters"][0]), tuning_["parameters"].back()["key"] = "other";
  std::string history = fmt::format("loss,{},other\n", kPayload);
  for (int i = 0; i < 20; ++i) history += fmt::format("{},a,{},1.{},1.{}\n", i, i, i % 10, i % 7);
  const std::string html = page(history);
  const std::string parallel = html.substr(html.find("data-figure='parallel'"));
  std::size_t settings = 0;
  for (std::size_t at = 0, line = 0; line < 3; ++line) {
    at = parallel.find("<path class='line", at + 1);
    const std::string path = parallel.substr(at, parallel.find('>', at) - at);
    settings += static_cast<std::size_t>(std::ranges::count(path, 'M'));
  }
  EXPECT_EQ(settings, 20u);
  const std::string plane = html.substr(html.find("data-figure='plane'"));
  EXPECT_THAT(plane.substr(0, plane.find("</figure>")), Has("lowest tenth"));
}

TEST_F(ReceivedTuning, AMissingHoldOutIsAnError) {
  tuning_["holdout"]["runs"] = json::array();
  EXPECT_THAT(files::error_of([&] { page(); }), Has("tune.json: holdout.runs: is empty"));
}

TEST(Table, ColumnsAreFoundByTheirNamesWithoutUnit) {
  const files::TemporaryFolder folder;
  const auto file = folder / "table.csv";
  files::write_text(file, "#timestamp [ns],b [m],kind\n1500000000,2.5,point\n2000000000,,line\n");
  const Table t(file);
  EXPECT_EQ(t.rows(), 2u);
  EXPECT_THAT(t.seconds("timestamp"), ElementsAre(1.5, 2));
  EXPECT_EQ(t.numbers("b")[0], 2.5);
  EXPECT_TRUE(std::isnan(t.numbers("b")[1])) << "an empty field is not zero";
  EXPECT_THAT(t.text("kind"), ElementsAre("point", "line"));
  EXPECT_THROW(t.text("a"), files::FileError);
  files::write_text(file, "");
  EXPECT_THROW(Table{file}, files::FileError);
}

class SweepPage : public testing::Test {
 protected:
  void add(const std::string& scenario, const json& settings, int seed, const json& values,
           const std::string& ending = "completed") {
    const json line{{"scenario", scenario}, {"settings", settings}, {"seed", seed},
                    {"ending", ending},     {"cause", ""},          {"values", values}};
    lines_ += line.dump() + "\n";
  }
  std::string page() const {
    files::write_text(folder_ / "scores.jsonl", lines_);
    files::write_text(folder_ / "trials.jsonl", "");
    EXPECT_TRUE(is_sweep(folder_.path()));
    return without_scripts(sweep_page(folder_.path()));
  }
  const files::TemporaryFolder folder_;
  std::string lines_;
};

TEST_F(SweepPage, OneKeyIsALineOfMediansAndItsWorstSeedIsNamedWithItsCommand) {
  for (const auto& [at, seed, ate] : {std::tuple{1, 1, 0.1}, {1, 2, 0.3}, {2, 1, 0.2}, {2, 2, 0.25}})
    add("hall", {{"slam.vision.sigma_px", at}}, seed, {{"ate_se3_rmse_m", ate}});
  const std::string html = page();
  EXPECT_THAT(html, Has("ate_se3_rmse_m over slam.vision.sigma_px", "slam.vision.sigma_px [px]",
                        "<summary>seed 2: 0.3</summary>",
                        "/scenarios/hall.yaml slam.vision.sigma_px=1 seed=2</pre>"));
  EXPECT_THAT(html, Has("<td class='number'>0.2</td>")) << "the median of 0.1 and 0.3";
}

TEST_F(SweepPage, EachNameInASweepIsOneWordOfTheCopiedCommand) {
  add("hall; touch a #", {{"slam.vision.sigma_px", "`id`"}}, 1, {{"rmse_m", 0.1}});
  add("hall; touch a #", {{"slam.vision.sigma_px", "1'; touch b; '"}}, 1, {{"rmse_m", 0.2}});
  EXPECT_THAT(page(),
              Has("/scenarios/hall; touch a #.yaml&#39; &#39;slam.vision.sigma_px=`id`&#39; seed=1</pre>",
                  "slam.vision.sigma_px=1&#39;\\&#39;&#39;; touch b; &#39;\\&#39;&#39;&#39; seed=1</pre>"));
}

TEST_F(SweepPage, NoCommandIsShownThatWouldStartAProgram) {
  std::filesystem::create_directory(folder_ / "scenarios");
  files::write_text(folder_ / "scenarios/hall.yaml",
                    "walk.commands: [{stand: {duration_s: 1}}]\ncamera: {}\nslam: {}\n");
  add("hall", {{"estimator", "{program: [sh, evil.sh]}"}}, 1, {{"rmse_m", 1}});
  add("hall", {{"estimator", "plan_alone"}}, 1, {{"rmse_m", 1}});
  EXPECT_THAT(page(), Has("<pre>its scenario names an external program as estimator</pre>",
                          "estimator=plan_alone seed=1</pre>"));
}

TEST_F(SweepPage, TwoKeysAreALineForEachValueOfTheOther) {
  for (const int a : {1, 10, 2})
    for (const char* b : {"x", "y"})
      add("hall", {{"slam.a", a}, {"slam.b", b}, {"slam.c", 0}}, 1, {{"rmse_m", a + (*b == 'y' ? 100 : 0)}});
  const std::string html = page();
  EXPECT_THAT(html, AllOf(Has("rmse_m over slam.a", "data-name='x' d='M", "data-name='y' d='M"),
                          Lacks("over slam.b", "a trial")));
  EXPECT_LT(html.find(">1</text>"), html.find(">10</text>")) << "10 comes after 2";
  lines_.clear();
  for (const int a : {1, 2})
    for (const int b : {3, 4}) add("hall", {{"slam.a", a}, {"slam.b", b}}, 1, {{"rmse_m", 1}});
  EXPECT_THAT(page(), Has("rmse_m over slam.a", "rmse_m over slam.b", "data-name='slam.b 3'",
                          "data-name='slam.a 2'"));
}

TEST_F(SweepPage, DrawsTheFirstOfManyKeysAndOnlyTheMedianOfManyTrials) {
  for (const int value : {1, 2}) {
    json settings;
    for (int k = 100; k < 200; ++k) settings["slam.k" + std::to_string(k)] = value;
    add("hall", settings, 1, {{"rmse_m", 1}});
  }
  std::string html = page();
  EXPECT_THAT(html, AllOf(Has("<figcaption>rmse_m over slam.k105<",
                              "There are figures for the first 6 of 100 keys with several values."),
                          Lacks("<figcaption>rmse_m over slam.k106<")));
  lines_.clear();
  for (int seed = 1; seed <= 501; ++seed)
    for (int a = 1; a <= 4; ++a) add("hall", {{"slam.a", a}}, seed, {{"rmse_m", 1}});
  html = page();
  EXPECT_THAT(html, Has("501 of 501</td>")) << "of a setting";
  EXPECT_THAT(html, AllOf(Has("data-name='median' d='M"), Not(ContainsRegex("M[0-9.]+ [0-9.]+h0"))));
}

TEST_F(SweepPage, ScenariosAreNotPooledAndAFailedTrialIsTheWorst) {
  add("hall", {{"slam.a", 1}}, 1, {{"ate_se3_rmse_m", 9}});
  add("hall", {{"slam.a", 1}}, 2, {{"ate_se3_rmse_m", 1}}, "diverged");
  add("office", {{"slam.a", 1}}, 1, {{"ate_se3_rmse_m", 3}});
  const std::string html = page();
  EXPECT_THAT(html, Has("<section id='scenario-hall'><h2>hall</h2>",
                        "<section id='scenario-office'><h2>office</h2>", "<td class='number'>5</td>"));
  EXPECT_THAT(html, Has("<td class='number'>3</td>")) << "not the median of both";
  EXPECT_THAT(html, Has("<summary>seed 2: diverged</summary>", "<td class='number'>1 of 2</td>"));
}

TEST_F(SweepPage, BrokenScoresAreReported) {
  for (const auto& [lines, complaint] : {std::pair{"", "scores.jsonl: has no trial"},
                                         {"{}\n", "scores.jsonl: scenario"},
                                         {"{\n", "scores.jsonl"}}) {
    lines_ = lines;
    EXPECT_THAT(files::error_of([&] { page(); }), Has(complaint));
  }
}

TEST(ReadRun, APositionOnlyTruthIsDrawnAlignedWithTheEstimate) {
  const files::TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) {
    files::write_text(folder / name, text);
  };
  const json metrics{{"ate_sim3_rmse_m", {{"value", 0.0}, {"unit", "m"}}}};
  write("score.json", json{{"scenario", "walk"},
                           {"seed", 1},
                           {"ending", "completed"},
                           {"metrics", metrics},
                           {"limits", json::array()}}
                          .dump());
  write("about.json", "{}");
  for (const char* empty : {"plan.tum", "waist_truth.tum", "waist_plan.tum"}) write(empty, "");
  write("truth.tum",
        "# timestamp(s) tx ty tz\n0 10 0 5\n1 10 1 5\n2 8 1 5\n3 8 1 6\n");  // turned by 90 degrees
  write("estimate_cov.txt", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 1 2 0 0 0 0 1\n3 1 2 1 0 0 0 1\n");
  const RunData run = read_run(folder.path());
  EXPECT_TRUE(run.truth_aligned);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(run.truth.x.at(i), run.estimate->x.at(i), 1e-9);
    EXPECT_NEAR(run.truth.y.at(i), run.estimate->y.at(i), 1e-9);
  }
}

RunData run(std::uint64_t seed, const std::map<std::string, double>& metrics) {
  RunData data;
  data.seed = seed;
  data.ending = scenario::Ending::completed;
  for (const auto& [name, value] : metrics) data.metrics.push_back({name, "", value});
  return data;
}

/// The cells of a metric in a table of changes; a key is given by its name.
std::vector<std::string> cells_of(const ChangeTable& table, const std::string& first) {
  for (const ChangeTable::Row& row : table.rows)
    if (row.cells[0] == first) return row.cells;
  return {};
}

TEST(Changes, ListKeysAndVerdictsOfCompareWithPValuesForEightSeedsOrMore) {
  for (const std::uint64_t seeds : {1, 8}) {
    std::vector<RunData> a, b;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      a.push_back(run(
          seed, {{"rmse_m", 0.01 + 0.0001 * double(seed)}, {"loop_landmarks", 20}, {"tracked_fraction", 1}}));
      b.push_back(
          run(seed,
              {{"rmse_m", 0.3 + 0.0002 * double(seed)}, {"loop_landmarks", 20}, {"tracked_fraction", 0.9}}));
      a.back().settings = {{"slam.k", "1"}, {"same", "x"}},
      b.back().settings = {{"slam.k", "2"}, {"same", "x"}};
    }
    const ChangeTable table = changes({&a[0], &b[0]}, {a.begin(), a.end()}, {b.begin(), b.end()});
    EXPECT_THAT(cells_of(table, "same"), IsEmpty());
    EXPECT_EQ(cells_of(table, "slam.k")[2], "2");
    const auto rmse = cells_of(table, "RMSE [mm]");
    EXPECT_EQ(rmse[1].substr(0, 3), "10.");
    EXPECT_EQ(rmse.back(), "FAIL");
    EXPECT_THAT(rmse[3], testing::MatchesRegex(".* \\(\\+[0-9]{4} %\\)"));
    EXPECT_EQ(cells_of(table, "loop landmarks").back(), "IDENTICAL");
    EXPECT_EQ(cells_of(table, "tracked").back(), "-") << "compare has no tolerance for it";
    const auto p = std::ranges::find(table.titles, "p") - table.titles.begin();
    ASSERT_EQ(p < std::ssize(table.titles), seeds == 8);
    if (seeds == 8) {
      EXPECT_EQ(rmse[std::size_t(p)], "0.0469") << "2 / 2^8 times six gates";
    }
  }
}

RunData run_by(const std::string& estimator, const std::map<std::string, double>& metrics,
               const std::map<std::string, std::string>& settings = {}) {
  RunData data = run(1, metrics);
  data.estimator = estimator, data.settings = settings;
  return data;
}

std::vector<std::string> estimators(const std::vector<RunData>& runs) {
  std::vector<std::string> names;
  for (const ResultRow& row : result_rows(runs)) names.push_back(row.estimator);
  return names;
}

TEST(ResultRows, CoverageComesBeforeTheError) {
  const auto with = [](double ate, double matched) {
    return std::map<std::string, double>{
        {"ate_se3_rmse_m", ate}, {"poses_matched", matched}, {"true_poses", 86}};
  };
  std::vector<RunData> runs{run_by("late", with(0.001, 26)), run_by("worse", with(0.2, 86)),
                            run_by("whole", with(0.1, 86)), run_by("fell", with(0.0001, 86))};
  runs.back().ending = scenario::Ending::fell;
  EXPECT_THAT(estimators(runs), ElementsAre("whole", "worse", "late", "fell"));
}

TEST(ResultRows, RunsWithAnotherEstimatorControllerRobotOrSettingAreNeverPooled) {
  const std::map<std::string, double> error{{"rmse_m", 0.1}};
  std::vector<RunData> runs;
  for (const char* const estimator : {"filter", "odometry"})
    for (const char* const controller : {"plan", "walker"})
      for (const char* const robot : {"hrp2", "g1"})
        runs.push_back(run_by(estimator, error, {{"walk.controller", controller}, {"world.robot", robot}}));
  EXPECT_EQ(result_rows(runs).size(), 8u);
  EXPECT_EQ(result_rows(runs).back().robot, "g1");
  EXPECT_EQ(result_rows(runs).back().setting, "") << "they have separate columns";
  EXPECT_THAT(runs_table(runs, TableFormat::markdown),
              StartsWith("| estimator | controller | robot | ATE [mm] |"));
  runs.push_back(runs.front());
  runs.back().seed = 2;
  EXPECT_EQ(result_rows(runs).size(), 8u) << "seeds are pooled";
  EXPECT_EQ(result_rows(runs)[0].completed(), 2u);
  runs.back().settings["slam.k"] = "[1,\n  2]", runs.front().settings["slam.k"] = "3";
  EXPECT_EQ(result_rows(runs).size(), 9u);
  EXPECT_THAT(runs_table(runs, TableFormat::csv), Has("filter,plan,hrp2,\"slam.k=[1, 2]\",1,1,"));
}

TEST(ResultRows, RunsWithOtherErrorsAreNotRankedAgainstEachOther) {
  const auto covered = [](double ate, const std::string& faults) {
    return run_by("filter", {{"ate_se3_rmse_m", ate}}, {{"errors.faults", faults}});
  };
  const auto rows = result_rows({covered(0.001, "[frames_covered: {}]"), covered(0.002, "[]")});
  EXPECT_EQ(rows.at(0).errors, "errors.faults=[]") << "although its error is larger";
  EXPECT_EQ(rows.at(1).setting, "");
}

// The intervals of eight seeds are 1 to 8, 5 to 12 and 21 to 28 mm; a metric near its expected value is
// better.
TEST(ResultRows, TheBestHasAnIntervalThatOverlapsNoOtherOfAtLeastSixRuns) {
  std::vector<RunData> runs;
  const auto add = [&](const std::string& estimator, double from, int seeds) {
    for (int seed = 1; seed <= seeds; ++seed)
      runs.push_back(run_by(estimator, {{"ate_se3_rmse_m", 1e-3 * (from + seed)},
                                        {"nees_position_mean", 3 + from / 3 + 0.01 * seed}}));
  };
  const auto best = [&](const std::string& metric) {
    std::vector<std::string> names;
    for (const ResultRow& row : result_rows(runs))
      if (row.find(metric)->best) names.push_back(row.estimator);
    return names;
  };
  add("a", 0, 8);
  EXPECT_THAT(best("ate_se3_rmse_m"), IsEmpty()) << "a single row";
  add("c", 20, 8);
  EXPECT_THAT(best("ate_se3_rmse_m"), ElementsAre("a"));
  add("b", 4, 8);
  EXPECT_THAT(best("ate_se3_rmse_m"), IsEmpty());
  EXPECT_THAT(best("nees_position_mean"), ElementsAre("a"));
  add("few", 300, 5);
  EXPECT_THAT(best("nees_position_mean"), IsEmpty());
}

TEST(ResultRows, ConsistencyIsAMeanAndFewSeedsHaveTheirRange) {
  for (const auto& [metric, center, low, high] :
       {std::tuple{"nees_position_mean", 4.0, 1.0, 9.0}, {"rmse_m", 2.0, 1.0, 9.0}}) {
    const OverSeeds few = over_seeds(metric, {1, 9, 2});
    EXPECT_EQ(few.center, center);
    EXPECT_EQ(few.spread, std::pair(low, high));
    EXPECT_FALSE(over_seeds(metric, {1}).spread);
  }
  const OverSeeds many = over_seeds("nees_position_mean", {1, 2, 3, 4, 5, 9});
  EXPECT_EQ(many.center, 4);
  EXPECT_NEAR(many.spread->first, 4 - 2.5706 * std::sqrt(8 / 6.0), 1e-3)
      << "Student's t, 5 degrees of freedom";
}

TEST(ResultRows, RunsThatFellAreCountedAndHaveNoValues) {
  std::vector<RunData> runs{run(1, {{"ate_se3_rmse_m", 0.002}}), run(2, {{"ate_se3_rmse_m", 0.0001}}),
                            run(3, {{"ate_se3_rmse_m", 0.0001}})};
  runs[1].ending = runs[2].ending = scenario::Ending::fell;
  EXPECT_THAT(
      runs_table(runs, TableFormat::markdown, {"ate_se3_rmse_m"}),
      StartsWith(
          "| estimator | completed | ATE [mm] |\n|---|---:|---:|\n| filter | 1 of 3 (2 fell) | 2.00 |\n"));
}

TEST(ResultRows, WalkersAreComparedByPathEnergyAndSlip) {
  const files::TemporaryFolder folder;
  RunData walk = run_by("filter", {{"navigation_rmse_m", 0.02}}, {{"world.robot", "a"}});
  files::write_text(
      folder / "feet.csv",
      "phase,moved_x [m],moved_y [m]\nput_down,9,9\nlanding,0.003,0\nsupport,0,0.004\nsupport,0,0.001\n");
  walk.feet.emplace(folder / "feet.csv");
  walk.recording = folder.path();
  std::filesystem::create_directories(folder / "truth");
  std::filesystem::create_directories(folder / "mav0/encoders0");
  files::write_text(folder / "truth/torques.csv",
                    "#timestamp [ns],a [N m],b [N m]\n0,1,1\n500000000,-2,10\n1000000000,4,10\n");
  files::write_text(folder / "mav0/encoders0/data.csv",
                    "#timestamp [ns],a [rad],b [rad]\n0,0,0\n500000000,0.5,0\n1000000000,0,0.1\n");
  RunData other = run_by("filter", {}, {{"world.robot", "b"}});
  const std::string table = runs_table({walk, other}, TableFormat::markdown);
  EXPECT_THAT(
      table,
      StartsWith(
          "| robot | ATE [mm] | path error [mm] | goal heading [deg] | slip per step [mm] | power [W] |\n"));
  EXPECT_THAT(table, Has("| a | - | 20.0 | - | 4.00 | 4.00 |\n", "| b | - | - | - | - | - |\n"));
}

TEST(ResultRows, AlignedAndUnalignedErrorsHaveSeparateColumns) {
  std::vector<RunData> runs{run_by("filter", {{"rmse_m", 0.25}}), run_by("filter", {{"rmse_m", 0.5}})};
  runs[1].alignment = "sim3";
  const std::string csv = runs_table(runs, TableFormat::csv);
  EXPECT_THAT(csv, Has(",rmse_m,m,1,median,0.25,", ",rmse_m_after_sim3,m,1,median,0.5,"));
  EXPECT_THAT(runs_table(runs, TableFormat::markdown), Has("| RMSE [mm] |", "| RMSE (sim3) [mm] |"));
}

TEST(Tables, FilesHaveUnitsCountsAndIntervalsAndEscapeTheirFormatsSpecialCharacters) {
  std::vector<RunData> runs;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    runs.push_back(run((seed + 1) / 2, {{"rmse_m", double(seed) / 64}, {"tracked_fraction", 1}}));
    runs.back().scenario = "a_b|c", runs.back().estimator = "=cmd\n\x1b";
    runs.back().settings["slam.k_x"] = seed % 2 ? "0.5" : "<";
  }
  const std::vector<std::string> metrics{"rmse_m", "tracked_fraction"};
  EXPECT_THAT(
      runs_table(runs, TableFormat::csv, metrics),
      StartsWith("scenario,errors,estimator,controller,robot,setting,runs,completed,coverage,metric,unit,n,"
                 "statistic,value,low,high,bracket,worst,worst_seed,best\n"
                 "a_b|c,,'=cmd??,,,slam.k_x=0.5,6,6,1,rmse_m,m,6,median,0.09375,0.015625,0.171875,95 % "
                 "confidence interval,0.171875,6,0\n"));
  EXPECT_THAT(runs_table(runs, TableFormat::latex, metrics),
              Has("setting & \\two{RMSE}{[mm]} & \\two{tracked}{} \\\\\n\\midrule\n"
                  "slam.\\allowbreak{}k\\_\\allowbreak{}x=\\allowbreak{}0.5 & \\two{93.8}{[15.6, 172]} & "
                  "\\two{1.00}{[1.00, 1.00]} \\\\\n",
                  "x=\\allowbreak{}\\textless{} & ",
                  "noindent Median of n = 6 completed runs [95 \\% confidence interval]."));
  EXPECT_THAT(
      runs_table(runs, TableFormat::markdown, metrics),
      Has("|---|---:|---:|\n| slam.k\\_x=0.5 | 93.8 [15.6, 172] | 1.00 [1.00, 1.00] |\n| slam.k\\_x=\\< |"));
  EXPECT_THROW(table_format("table.xls"), std::invalid_argument);
}

RunData tracked_run(const std::map<std::string, double>& metrics) {
  RunData data = run(1, metrics);
  for (const int t : {0, 43}) data.frames.push_back({.t = std::chrono::seconds(t)});
  data.settings = {{"slam.vision.sigma_px", "0.22"},      {"slam.vision.sigma_first_px", "0.12"},
                   {"slam.leg_odometry.enabled", "true"}, {"slam.leg_odometry.sigma_m_s", "0.001"},
                   {"slam.leg_odometry.sigma_sway", "0"}, {"slam.plan_velocity.sigma_m_s", "0.02"},
                   {"slam.gyro.sigma_rad_s", "0.01"},     {"errors.gyro.sigma_rad_s", "0.01"}};
  return data;
}

// Eight draws of three degrees of freedom: chi-square with 24, 9.89 to 45.6 in 99 %, by 24.
TEST(NoiseRemarks, NameTheSensorTheFactorAndWhatWouldFitAndNothingIfConsistent) {
  EXPECT_THAT(noise_remarks(tracked_run({{"nis_vision_mean", 0.42},
                                         {"nis_plan_velocity_mean", 1.89},
                                         {"nees_position_mean", 12},
                                         {"nees_orientation_mean", 0.08}})),
              IsEmpty());
  EXPECT_THAT(
      noise_remarks(tracked_run({{"nis_vision_mean", 0.05}, {"nis_plan_velocity_mean", 4}})),
      ElementsAre("images: NIS 0.05 (consistent: 0.41 to 1.9): the assumed noise is about 4.5 times too "
                  "large; slam.vision.sigma_px 0.22 → 0.049 would fit",
                  "leg odometry: NIS 4 (consistent: 0.41 to 1.9): the assumed noise is at least 2 times too "
                  "small; slam.leg_odometry.sigma_m_s 0.001 → 0.002 or more would fit"));
  EXPECT_THAT(
      noise_remarks(tracked_run({{"nis_plan_velocity_mean", 1.6}, {"nees_position_mean", 27}})),
      ElementsAre("position: NEES 27 (consistent: 0.072 to 13): the stated standard deviations are about 3 "
                  "times too small; the largest NIS is that of leg odometry (1.6)"));
  RunData simulated = tracked_run({});
  simulated.waist_truth.t = {0};
  EXPECT_THAT(noise_remarks(simulated), IsEmpty());
  simulated.settings["slam.gyro.sigma_rad_s"] = "0.04";
  EXPECT_THAT(noise_remarks(simulated),
              ElementsAre("errors.gyro.sigma_rad_s is 0.01: the assumed noise is about 4 times too large; "
                          "slam.gyro.sigma_rad_s 0.04 → 0.01 would fit"));
}

const PaperRow& row(const std::vector<PaperRow>& rows, const std::string& what) {
  const auto found = std::ranges::find_if(rows, [&](const PaperRow& r) { return r.what.starts_with(what); });
  if (found == rows.end()) throw std::runtime_error("no row " + what);
  return *found;
}

TEST(PaperRows, DriftsAgreeWithinAFactorOfTwoWhateverTheirSignsOrIfNegligible) {
  PaperRuns runs;
  runs["perpendicular_circle_trial1"] = {
      run(1, {{"plan_drift_x_m", 0.09}, {"plan_drift_y_m", -0.34}, {"plan_drift_yaw_deg", 29}}),
      run(2, {{"plan_drift_x_m", 0.11}, {"plan_drift_y_m", -0.36}, {"plan_drift_yaw_deg", 31}})};
  const auto rows = paper_rows(runs);
  const auto& x = row(rows, "Facing the center, first trial: drift in X");
  EXPECT_EQ(x.paper, "240 mm");
  EXPECT_EQ(x.bench, "100.0 mm (sd 14.1)") << "the sample deviation of 90 and 110";
  EXPECT_EQ(x.agreement, "differs") << "100 is below 240 / 2";
  EXPECT_EQ(row(rows, "Facing the center, first trial: drift in Y").agreement, "agrees");
  EXPECT_EQ(row(rows, "Facing the center, first trial: drift in yaw").agreement, "agrees");
  for (const auto& [ahead, yaw, agreement] : {std::tuple{-0.009, 0.9, "agrees"}, {-0.012, 1.1, "differs"}}) {
    const auto small = paper_rows(
        {{"tangent_quadrant", {run(1, {{"plan_drift_x_m", ahead}, {"plan_drift_yaw_deg", yaw}})}}});
    EXPECT_EQ(row(small, "Tangent quadrant: drift in X").agreement, agreement);
    EXPECT_EQ(row(small, "Tangent quadrant: drift in yaw").agreement, agreement);
  }
}

TEST(PaperRows, ClosingWhereThePaperFailedDiffersForItsFilterAndIsBetterForOurs) {
  PaperRuns runs;
  runs["hall_paper"] = runs["hall"] =
      runs["tangent_circle"] = {run(1, {{"loop_closed", 1}, {"loop_landmarks", 12}})};
  EXPECT_EQ(row(paper_rows(runs), "The hall, the paper's filter").agreement, "differs");
  EXPECT_EQ(row(paper_rows(runs), "The hall, GaitSLAM's filter").agreement, "better");
  EXPECT_EQ(row(paper_rows(runs), "Experiment 1, GaitSLAM's filter").agreement, "agrees");
  runs["hall_paper"].push_back(run(2, {{"loop_closed", 0}}));
  EXPECT_THAT(row(paper_rows(runs), "The hall, the paper's filter").bench, Has("1 of 2 closed"));
  EXPECT_THAT(row(paper_rows(runs), "The hall, the paper's filter").bench,
              Has("Likely cause of the difference"));
  runs["hall"].push_back(run(2, {{"loop_closed", 0}}));
  EXPECT_EQ(row(paper_rows(runs), "The hall, GaitSLAM's filter").agreement, "differs");
  runs["tangent_circle"].push_back(run(2, {{"loop_closed", 0}}));
  EXPECT_EQ(row(paper_rows(runs), "Experiment 1, GaitSLAM's filter").agreement, "differs");
}

TEST(PaperRows, OneRunHasNoSpreadTimesAreNotComparedAndThePageCountsTheRows) {
  PaperRuns runs;
  runs["tangent_quadrant"] = {run(1, {{"plan_drift_x_m", -0.009}})};
  const auto rows = paper_rows(runs);
  EXPECT_EQ(row(rows, "Tangent quadrant: drift in X").bench, "-9.0 mm");
  EXPECT_EQ(std::ranges::count_if(
                rows, [](const PaperRow& r) { return r.bench == "not run" && r.agreement.empty(); }),
            std::ssize(rows) - 1);
  EXPECT_THAT(paper_page(runs, "abc"),
              Has("<p>1 experiment, 1 seed each. Comparable rows: 1; agree: 1; better than the paper: 0; "
                  "<strong>differ: 0</strong>. Not comparable: " +
                  std::to_string(rows.size() - 1) + ".</p>"));
  runs["tangent_circle"] = {run(1, {{"loop_closed", 1}, {"loop_landmarks", 12}})};
  runs["tangent_circle"][0].frame_cpu_ms_median = 0.5;
  EXPECT_EQ(row(paper_rows(runs), "Experiment 1, GaitSLAM's filter").bench,
            "1 of 1 closed; landmarks recognized: 12; ATE none");
  const PaperRow time = row(paper_rows(runs), "CPU time of a frame, GaitSLAM's filter");
  EXPECT_EQ(time.bench, "0.5 ms, on a different computer: not comparable");
  EXPECT_EQ(time.agreement, "");
}

/// Figure 3 of a depths.csv with these rows.
Figure depths(const std::string& rows) {
  const files::TemporaryFolder folder;
  files::write_text(folder / "depths.csv", "#timestamp [ns],landmark,depth [m],probability\n" + rows);
  return depths_figure(folder / "depths.csv");
}

TEST(Depths, TheFigureShowsTheLandmarkThatTookTheMostImagesToBecomeKnown) {
  const Figure f = depths(
      "0,1,2,0.5\n0,1,8,0.5\n"                  // 1: never known
      "0,2,3,0.5\n0,2,5,0.5\n33000000,2,4,1\n"  // 2: after two images
      "0,3,1,0.5\n0,3,9,0.5\n1,3,5,0.5\n1,3,9,0.5\n2,3,6,0.9\n2,3,7,0.1\n3,3,6,1\n");
  ASSERT_THAT(f.lines, SizeIs(4));
  EXPECT_EQ(f.lines[0].name, "after 1 image");
  EXPECT_THAT(f.lines[0].x, ElementsAre(1, 9));
  EXPECT_EQ(f.lines[3].name, "after 4 images");
  EXPECT_THAT(f.lines[3].y, ElementsAre(1));
  EXPECT_THAT(depths("0,1,2,0.5\n0,1,8,0.5\n").lines, IsEmpty()) << "no depth became known";
}

}  // namespace
}  // namespace sim::pages
