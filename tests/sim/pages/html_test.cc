#include "sim/pages/html.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "tests/sim/files/has.h"
#include "tests/sim/files/temporary_folder.h"

namespace {

using namespace sim::pages;
using nlohmann::json, testing::AllOf, tests::Has, tests::Lacks;

constexpr const char* kPayload = R"(</title></script><img src=x onerror='a()'>"<!--&)";
constexpr const char* kShown =
    "&lt;/title&gt;&lt;/script&gt;&lt;img src=x onerror=&#39;a()&#39;&gt;&quot;&lt;!--&amp;";

TEST(Html, TextIsShownAsItIsInElementsAndAttributes) {
  EXPECT_EQ(escaped(kPayload), kShown);
  EXPECT_EQ(escaped("ATE of 5 mm, 3 \xcf\x83"), "ATE of 5 mm, 3 \xcf\x83");
}

TEST(Html, DataCannotEndItsScriptElement) {
  const std::string html = data_script("data", json{{"name", kPayload}}.dump());
  const std::string inside = html.substr(html.find('>') + 1, html.rfind("</script>") - html.find('>') - 1);
  EXPECT_THAT(inside, Lacks("<"));
  EXPECT_EQ(json::parse(inside)["name"], kPayload);
}

TEST(Html, ThePolicyAllowsTheScriptsByTheirHashesAndNothingElse) {
  const std::string with = html_page("a", "", "", {"alert('Hello, world.');"}),
                    without = html_page("a", "", "", {});
  // The example of the specification of Content Security Policies, level 3, section 8.3.
  EXPECT_THAT(with, Has("script-src 'sha256-qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng=';"));
  EXPECT_THAT(without, Has("script-src 'none';"));
  for (const std::string& page : {with, without}) {
    EXPECT_THAT(page, AllOf(Has("default-src 'none';", "base-uri 'none'; form-action 'none'"),
                            Lacks("script-src 'unsafe-inline'")));
    EXPECT_LT(page.find("Content-Security-Policy"), page.find("<title>")) << "it applies to what follows it";
  }
}

TEST(Html, Base64GivesTheTestVectorsOfRfc4648) {
  for (const auto& [bytes, text] : {std::pair{"", ""}, {"f", "Zg=="}, {"fo", "Zm8="}, {"foobar", "Zm9vYmFy"}})
    EXPECT_EQ(base64(bytes), text);
}

/// Without the scripts of the page, which are the same for all.
std::string without_scripts(const std::string& page) { return page.substr(0, page.find("<script>")); }

void expect_harmless(const std::string& page) {
  const std::string html = without_scripts(page);
  EXPECT_THAT(html, AllOf(Has("Content-Security-Policy", kShown), Lacks("<img", "<script")));
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
    tuning_["parameters"] = json::array({parameter});
    tuning_["training"] = tuning_["holdout"] = side;
  }
  std::string page() const {
    std::ofstream(folder_ / "tune.json") << tuning_.dump();
    std::ofstream(folder_ / "history.csv")
        << "#setting,origin," << kPayload << "," << kPayload << "2\n0,a,1.5,3\n1,a,1.2,2\n";
    return tune_page(folder_.path());
  }
  json tuning_;
  const sim::files::TemporaryFolder folder_;
};

TEST_F(ReceivedTuning, NamesAreShownAsTheyAreAndRunsBeforeAndAfterWithTheirMeans) {
  EXPECT_THAT(page(), Has("<tr><td>mean</td><td class='number'>1.5</td><td class='number'>1</td>"));
  tuning_["objective"] = std::string(kPayload) + "2";
  for (const char* side : {"training", "holdout"})
    tuning_[side]["values"][std::string(kPayload) + "2"] = tuning_[side]["values"][kPayload];
  expect_harmless(page());
}

TEST_F(ReceivedTuning, AHoldOutOfOneRunIsAWarningAndNoneAnError) {
  EXPECT_THAT(page(), Lacks("The hold-out is one run"));
  tuning_["holdout"]["runs"] = {"walks/seed-3"};
  EXPECT_THAT(page(), Has("The hold-out is one run", "<td>walks/seed-3</td>"));
  tuning_["holdout"]["runs"] = json::array();
  EXPECT_THAT(sim::files::error_of([&] { page(); }), Has("tune.json: holdout.runs: is empty"));
}

TEST(PaperPage, TheRevisionIsShownAsItIs) { expect_harmless(paper_page({}, kPayload)); }

TEST(Figure, NamesAreShownAsTheyAre) {
  Figure figure{"a", kPayload, kPayload, kPayload};
  figure.lines = {{kPayload, Role::truth, {0, 1}, {0, 1}}};
  figure.levels = {{kPayload, 0.5}};
  figure.moments = {{kPayload, 0.5}};
  EXPECT_THAT(to_svg(figure, 100, 100), AllOf(Has(kShown), Lacks("<img")));
}

TEST(Table, ColumnsAreFoundByTheirNamesWithoutUnit) {
  const sim::files::TemporaryFolder folder;
  const auto file = folder / "table.csv";
  sim::files::write_text(file, "#timestamp [ns],b [m],kind\n1500000000,2.5,point\n2000000000,,line\n");
  const Table t(file);
  EXPECT_EQ(t.rows(), 2u);
  EXPECT_THAT(t.seconds("timestamp"), testing::ElementsAre(1.5, 2));
  EXPECT_EQ(t.numbers("b")[0], 2.5);
  EXPECT_TRUE(std::isnan(t.numbers("b")[1])) << "an empty field is not zero";
  EXPECT_THAT(t.text("kind"), testing::ElementsAre("point", "line"));
  EXPECT_THROW(t.text("a"), sim::files::FileError);
  sim::files::write_text(file, "");
  EXPECT_THROW(Table{file}, sim::files::FileError);
}

class SweepPage : public testing::Test {
 protected:
  void add(const std::string& scenario, const json& settings, int seed, const json& values,
           const std::string& ending = "completed") {
    const json line{{"trial", 0},   {"scenario", scenario}, {"settings", settings}, {"key", "k"},
                    {"seed", seed}, {"ending", ending},     {"cause", ""},          {"values", values}};
    lines_ += line.dump() + "\n";
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
  for (const auto& [at, seed, ate] : {std::tuple{1, 1, 0.1}, {1, 2, 0.3}, {2, 1, 0.2}, {2, 2, 0.25}})
    add("hall", {{"slam.vision.sigma_px", at}}, seed, {{"ate_se3_rmse_m", ate}});
  const std::string html = page();
  EXPECT_THAT(html, Has("ate_se3_rmse_m over slam.vision.sigma_px", "slam.vision.sigma_px [px]",
                        "<summary>seed 2: 0.3</summary>", "<tr id='setting-hall-1'>",
                        "/scenarios/hall.yaml slam.vision.sigma_px=1 seed=2</pre>"));
  EXPECT_THAT(html, Has("<td class='number'>0.2</td>")) << "the median of 0.1 and 0.3";
}

TEST_F(SweepPage, WhatASweepNamesIsOneWordEachOfACommandThatIsCopied) {
  add("hall; touch a #", {{"slam.vision.sigma_px", "`id`"}}, 1, {{"rmse_m", 0.1}});
  add("hall; touch a #", {{"slam.vision.sigma_px", "1'; touch b; '"}}, 1, {{"rmse_m", 0.2}});
  const std::string html = page();
  EXPECT_THAT(html,
              Has("/scenarios/hall; touch a #.yaml&#39; &#39;slam.vision.sigma_px=`id`&#39; seed=1</pre>",
                  "slam.vision.sigma_px=1&#39;\\&#39;&#39;; touch b; &#39;\\&#39;&#39;&#39; seed=1</pre>"));
}

TEST_F(SweepPage, NoCommandIsShownThatWouldStartAProgram) {
  std::filesystem::create_directory(folder_ / "scenarios");
  sim::files::write_text(folder_ / "scenarios/hall.yaml",
                         "walk.commands: [{stand: {duration_s: 1}}]\ncamera: {}\nslam: {}\n");
  add("hall", {{"estimator", "{program: [sh, evil.sh]}"}}, 1, {{"rmse_m", 1}});
  add("hall", {{"estimator", "plan_alone"}}, 1, {{"rmse_m", 1}});
  const std::string html = page();
  EXPECT_THAT(html, Has("<pre>its scenario names an external program as estimator</pre>",
                        "estimator=plan_alone seed=1</pre>"));
}

TEST_F(SweepPage, TwoKeysAreAHeatMapWhoseCellsOpenTheirRows) {
  for (const int a : {1, 10, 2})
    for (const char* b : {"x", "y"}) add("hall", {{"slam.a", a}, {"slam.b", b}}, 1, {{"rmse_m", 0.125}});
  const std::string html = page();
  EXPECT_THAT(html, Has("rmse_m [m]: median over seeds"));
  EXPECT_THAT(html, Has("<a href='#setting-hall-3-2'>0.125</a>")) << "10 comes after 2";
  EXPECT_THAT(html, Lacks("rmse_m over slam.a"));
}

TEST_F(SweepPage, OfManyKeysHasFiguresOfTheFirstOnesAndOfManyTrialsTheMedianAlone) {
  for (const int value : {1, 2}) {
    json settings;
    for (int k = 100; k < 200; ++k) settings["slam.k" + std::to_string(k)] = value;
    add("hall", settings, 1, {{"rmse_m", 1}});
  }
  std::string html = page();
  EXPECT_THAT(html, AllOf(Has("<th>slam.k105 \\ slam.k104</th>", "<figcaption>rmse_m over slam.k105<",
                              "Figures are drawn of the first 6 of 100 keys with several values."),
                          Lacks("<th>slam.k106 \\ slam.k105</th>", "<figcaption>rmse_m over slam.k106<")));
  lines_.clear();
  for (int seed = 1; seed <= 501; ++seed)
    for (int a = 1; a <= 4; ++a) add("hall", {{"slam.a", a}}, seed, {{"rmse_m", 1}});
  html = page();
  EXPECT_THAT(html, Has("501 of 501</td>")) << "of a setting";
  EXPECT_THAT(html, AllOf(Has("data-name='median' d='M"), Not(testing::ContainsRegex("M[0-9.]+ [0-9.]+h0"))));
}

TEST_F(SweepPage, ScenariosAreNotPooledAndATrialThatFailedIsTheWorst) {
  add("hall", {{"slam.a", 1}}, 1, {{"ate_se3_rmse_m", 9}});
  add("hall", {{"slam.a", 1}}, 2, {{"ate_se3_rmse_m", 1}}, "diverged");
  add("office", {{"slam.a", 1}}, 1, {{"ate_se3_rmse_m", 3}});
  const std::string html = page();
  EXPECT_THAT(html, Has("<section id='scenario-hall'><h2>hall</h2>",
                        "<section id='scenario-office'><h2>office</h2>", "<td class='number'>5</td>"));
  EXPECT_THAT(html, Has("<td class='number'>3</td>")) << "not the median of both";
  EXPECT_THAT(html, Has("<summary>seed 2: diverged</summary>", "<td class='number'>1 of 2</td>"));
}

TEST_F(SweepPage, NamesAreShownAsTheyAre) {
  add("<img src=x>", {{"<b>", "'\"<i>"}}, 1, {{"rmse_m", 1}});
  const std::string html = page();
  EXPECT_THAT(html, AllOf(Has("Content-Security-Policy"), Lacks("<img", "<i>")));
}

TEST_F(SweepPage, BrokenScoresAreNamed) {
  for (const auto& [lines, complaint] : {std::pair{"", "scores.jsonl: has no trial"},
                                         {"{}\n", "scores.jsonl: scenario"},
                                         {"{\n", "scores.jsonl"}}) {
    lines_ = lines;
    EXPECT_THAT(sim::files::error_of([&] { page(); }), Has(complaint));
  }
}

}  // namespace
