#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/regression/report.h"

namespace sim::regression {
namespace {

using testing::HasSubstr;
using testing::Not;

Comparison comparison() {
  ScenarioVerdict walk;
  walk.name = "tangent_circle";
  walk.n_baseline = walk.n_now = 10;
  walk.metrics.push_back({{"ate_se3_rmse_m", 10, 0.001},
                          10,
                          0.041,
                          0.052,
                          0.011,
                          std::pair(0.008, 0.02),
                          0.004,
                          Verdict::fail,
                          "",
                          7});
  walk.metrics.push_back({{"loop_landmarks", 0, 2}, 10, 18, 18, 0, {}, {}, Verdict::identical, "", 1});
  walk.metrics.push_back({{"rmse_m", 5, 0}, 10, {}, 1.0, {}, {}, {}, Verdict::added, "", 1});
  walk.limits.push_back({"loop_closed.worst >= 1", "0", false, false, 3});
  walk.limits.push_back(
      {"ending completed", "9/10", false, true, 4, {"seed 4 fell: to the left\nits last lines:\na | b"}});
  walk.wall_s = 12.5;
  walk.limits.push_back({"rmse_m <= 1", "10/10", true, false, 0});
  return {"a title, with 5 % & more",
          {walk},
          [](const std::string& name) { return "scenarios/" + name + ".yaml"; },
          [](const std::string& name, std::uint64_t seed) {
            return "tools/gaitslam run scenarios/" + name + ".yaml seed=" + std::to_string(seed);
          }};
}

TEST(VerdictTable, FitsEightyColumnsAndHasACommandForEachFailure) {
  const std::string text = verdict_table(comparison(), false);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
  EXPECT_THAT(text, testing::ContainsRegex(
                        "ate_se3_rmse_m +0.041 +0.052 +\\+27 % +\\[\\+20,\\+49\\] +0.004  FAIL\n"));
  EXPECT_THAT(text, HasSubstr("tolerance 10 % or 0.001 m; worst seed 7\n"));
  EXPECT_THAT(text, HasSubstr("  again:\n    tools/gaitslam run scenarios/tangent_circle.yaml seed=7\n"));
  EXPECT_THAT(text, testing::ContainsRegex("loop_landmarks +18 +18 +0 % +- +-  IDENTICAL\n"));
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
                    "message=\"FAIL: 0.041 m -&gt; 0.052 m (+27 %; tolerance 10 % or 0.001 "
                    "m)\">tools/gaitslam run"),
          HasSubstr("name=\"limit ending completed\" time=\"0.000\"><error message=\"RUN FAILED: observed: "
                    "9/10; seed 4 fell: to the left\">tools/gaitslam run"),
          HasSubstr("seed 4 fell: to the left&#10;its last lines:&#10;a | b</error>"),
          HasSubstr("<skipped message=\"NEW: none -&gt; 1 m (-; tolerance 5 %)\"/>")));
}

TEST(VerdictReports, AnnotationsAreEscapedAsGithubWantsThem) {
  const std::string text = github_annotations(comparison());
  EXPECT_THAT(text, testing::StartsWith("::error file=scenarios/tangent_circle.yaml,title=tangent_circle "
                                        "ate_se3_rmse_m%3A FAIL::0.041 m -> 0.052 m (+27 %25; "));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
}

TEST(VerdictReports, MarkdownHasEveryRowAndTheLastLinesOfAFailedRun) {
  EXPECT_THAT(markdown(comparison()),
              testing::AllOf(HasSubstr("| `ate_se3_rmse_m` | **FAIL** | 0.041 m -> 0.052 m (+27 %"),
                             HasSubstr("| `limit rmse_m <= 1` | ok | observed: 10/10 |\n"),
                             HasSubstr("observed: 9/10; seed 4 fell: to the left<br>`tools/gaitslam run"),
                             HasSubstr("<br>`its last lines:`<br>`a \\| b` |\n")));
}

TEST(VerdictReports, JsonHasEveryRow) {
  const auto json = nlohmann::json::parse(verdicts_json(comparison())), walk = json["scenarios"][0];
  EXPECT_EQ(json["exit_code"], 3);
  EXPECT_EQ(walk["metrics"][0]["verdict"], "FAIL");
  EXPECT_EQ(walk["metrics"][0]["change_band_95"][1], 0.02);
  EXPECT_TRUE(walk["metrics"][2]["baseline_median"].is_null());
  EXPECT_EQ(walk["limits"].size(), 3u);
  EXPECT_EQ(walk["wall_s"], 12.5);
}

}  // namespace
}  // namespace sim::regression
