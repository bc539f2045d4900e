#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "tests/sim/files/temporary_folder.h"

namespace {

using sim::pages::sweep_page;
using testing::HasSubstr;
using testing::Not;

class SweepPage : public testing::Test {
 protected:
  /// One trial's line; settings: {"slam.a": 1, ...}.
  void add(const std::string& scenario, const std::string& settings, int seed, const std::string& values,
           const std::string& ending = "completed") {
    lines_ += R"({"trial": 0, "scenario": ")" + scenario + R"(", "settings": )" + settings +
              R"(, "key": "k", "seed": )" + std::to_string(seed) + R"(, "ending": ")" + ending +
              R"(", "cause": "", "values": )" + values + "}\n";
  }
  std::string page() const {
    sim::files::write_text(folder_ / "scores.jsonl", lines_);
    sim::files::write_text(folder_ / "trials.jsonl", "");
    EXPECT_TRUE(sim::pages::is_sweep(folder_.path()));
    const std::string page = sweep_page(folder_.path());
    return page.substr(0, page.find("<script>"));
  }
  const sim::files::TemporaryFolder folder_;
  std::string lines_;
};

TEST_F(SweepPage, OneKeyIsALineOfMediansAndItsWorstSeedIsNamedWithItsCommand) {
  for (const auto& [at, seed, ate] :
       {std::tuple{"1", 1, "0.1"}, {"1", 2, "0.3"}, {"2", 1, "0.2"}, {"2", 2, "0.25"}})
    add("hall", std::string(R"({"slam.vision.sigma_px": )") + at + "}", seed,
        std::string(R"({"ate_se3_rmse_m": )") + ate + "}");
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("ate_se3_rmse_m over slam.vision.sigma_px"));
  EXPECT_THAT(html, HasSubstr("slam.vision.sigma_px [px]"));
  EXPECT_THAT(html, HasSubstr("<summary>seed 2: 0.3</summary>"));
  EXPECT_THAT(html, HasSubstr("<tr id='setting-hall-1'>"));
  EXPECT_THAT(html, HasSubstr("/scenarios/hall.yaml slam.vision.sigma_px=1 seed=2</pre>"));
  EXPECT_THAT(html, HasSubstr("<td class='number'>0.2</td>")) << "the median of 0.1 and 0.3";
}

TEST_F(SweepPage, WhatASweepNamesIsOneWordEachOfACommandThatIsCopied) {
  add("hall; touch a #", R"({"slam.vision.sigma_px": "`id`"})", 1, R"({"rmse_m": 0.1})");
  add("hall; touch a #", R"({"slam.vision.sigma_px": "1'; touch b; '"})", 1, R"({"rmse_m": 0.2})");
  const std::string html = page();
  EXPECT_THAT(
      html,
      HasSubstr("/scenarios/hall; touch a #.yaml&#39; &#39;slam.vision.sigma_px=`id`&#39; seed=1</pre>"));
  EXPECT_THAT(
      html,
      HasSubstr("slam.vision.sigma_px=1&#39;\\&#39;&#39;; touch b; &#39;\\&#39;&#39;&#39; seed=1</pre>"));
}

TEST_F(SweepPage, NoCommandIsShownThatWouldStartAProgram) {
  std::filesystem::create_directory(folder_ / "scenarios");
  sim::files::write_text(folder_ / "scenarios/hall.yaml",
                         "walk.commands: [{stand: {duration_s: 1}}]\ncamera: {}\nslam: {}\n");
  add("hall", R"({"estimator": "{program: [sh, evil.sh]}"})", 1, R"({"rmse_m": 1})");
  add("hall", R"({"estimator": "plan_alone"})", 1, R"({"rmse_m": 1})");
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("<pre>its scenario names an external program as estimator</pre>"));
  EXPECT_THAT(html, HasSubstr("estimator=plan_alone seed=1</pre>"));
}

TEST_F(SweepPage, TwoKeysAreAHeatMapWhoseCellsOpenTheirRows) {
  for (const char* a : {"1", "10", "2"})
    for (const char* b : {"x", "y"})
      add("hall", std::string(R"({"slam.a": )") + a + R"(, "slam.b": ")" + b + "\"}", 1,
          R"({"rmse_m": 0.125})");
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("rmse_m [m]: median over seeds"));
  EXPECT_THAT(html, HasSubstr("<a href='#setting-hall-3-2'>0.125</a>")) << "10 comes after 2";
  EXPECT_THAT(html, Not(HasSubstr("rmse_m over slam.a")));
}

TEST_F(SweepPage, OfManyKeysHasFiguresOfTheFirstOnes) {
  for (const int value : {1, 2}) {
    nlohmann::json settings;
    for (int k = 100; k < 200; ++k) settings["slam.k" + std::to_string(k)] = value;
    add("hall", settings.dump(), 1, R"({"rmse_m": 1})");
  }
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("<th>slam.k105 \\ slam.k104</th>"));
  EXPECT_THAT(html, Not(HasSubstr("<th>slam.k106 \\ slam.k105</th>")));
  EXPECT_THAT(html, HasSubstr("<figcaption>rmse_m over slam.k105<"));
  EXPECT_THAT(html, Not(HasSubstr("<figcaption>rmse_m over slam.k106<")));
  EXPECT_THAT(html, HasSubstr("Figures are drawn of the first 6 of 100 keys with several values."));
}

TEST_F(SweepPage, OfManyTrialsHasTheMedianAlone) {
  for (int seed = 1; seed <= 501; ++seed)
    for (int a = 1; a <= 4; ++a)
      add("hall", R"({"slam.a": )" + std::to_string(a) + "}", seed, R"({"rmse_m": 1})");
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("501 of 501</td>")) << "of a setting";
  EXPECT_THAT(html, Not(testing::ContainsRegex("M[0-9.]+ [0-9.]+h0")));
  EXPECT_THAT(html, HasSubstr("data-name='median' d='M"));
}

TEST_F(SweepPage, ScenariosAreNotPooled) {
  add("hall", R"({"slam.a": 1})", 1, R"({"rmse_m": 1})");
  add("office", R"({"slam.a": 1})", 1, R"({"rmse_m": 3})");
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("<section id='scenario-hall'><h2>hall</h2>"));
  EXPECT_THAT(html, HasSubstr("<section id='scenario-office'><h2>office</h2>"));
  EXPECT_THAT(html, Not(HasSubstr("<td class='number'>2</td>"))) << "the median of both";
}

TEST_F(SweepPage, ATrialThatFailedIsTheWorst) {
  add("hall", R"({"slam.a": 1})", 1, R"({"ate_se3_rmse_m": 9})");
  add("hall", R"({"slam.a": 1})", 2, R"({"ate_se3_rmse_m": 1})", "diverged");
  EXPECT_THAT(page(), HasSubstr("<summary>seed 2: diverged</summary>"));
  EXPECT_THAT(page(), HasSubstr("<td class='number'>1 of 2</td>"));
}

TEST_F(SweepPage, NamesAreShownAsTheyAre) {
  add("<img src=x>", R"({"<b>": "'\"<i>"})", 1, R"({"rmse_m": 1})");
  const std::string html = page();
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_THAT(html, Not(HasSubstr("<i>")));
  EXPECT_THAT(html, HasSubstr("Content-Security-Policy"));
}

TEST_F(SweepPage, BrokenScoresAreNamed) {
  for (const auto& [lines, complaint] : {std::pair{"", "scores.jsonl: has no trial"},
                                         {"{}\n", "scores.jsonl: scenario"},
                                         {"{\n", "scores.jsonl"}}) {
    lines_ = lines;
    try {
      page();
      ADD_FAILURE() << complaint;
    } catch (const sim::files::FileError& e) {
      EXPECT_THAT(e.what(), HasSubstr(complaint));
    }
  }
}

}  // namespace
