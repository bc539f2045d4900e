// Reports made by the program and opened in a browser.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <vector>

#include "tests/tools/command_line.h"

namespace {

using testing::HasSubstr;
using testing::Not;
using tests::Ran;

// Returns the shell command that prints a page of this folder after its script ran and, on standard error,
// the browser's console. No host name resolves: the page cannot load other files.
std::string browser_command(const std::string& page) {
  return "timeout 100 chromium --headless --no-sandbox --user-data-dir=profile --use-angle=swiftshader "
         "--enable-unsafe-swiftshader --host-resolver-rules='MAP * ~NOTFOUND' --enable-logging=stderr "
         "--window-size=1200,900 --virtual-time-budget=10000 --dump-dom \"file://$PWD/" +
         page + "\"";
}

class ReportTest : public tests::CommandLine {
 protected:
  ReportTest() { write("walk.yaml", tests::kShortWalk); }
  void walk(const std::string& arguments) { ASSERT_EQ(gaitslam("run walk.yaml " + arguments).exit_code, 0); }

  Ran opened(const std::string& page) const { return shell(browser_command(page)); }
  void expect_all_drawn(const std::string& page, int at_least) const {
    const Ran ran = opened(page);
    std::smatch figures, drawn;
    ASSERT_TRUE(std::regex_search(ran.out, figures, std::regex("data-figures=\"(\\d+)\""))) << ran.err;
    ASSERT_TRUE(std::regex_search(ran.out, drawn, std::regex("data-drawn=\"(\\d+)\""))) << ran.err;
    EXPECT_EQ(figures[1], drawn[1]);
    EXPECT_GE(std::stoi(drawn[1]), at_least);
    EXPECT_THAT(ran.err, Not(HasSubstr("CONSOLE"))) << "the browser's console is not empty";
  }
};
using LongReportTest = ReportTest;

TEST_F(ReportTest, EveryFigureOfARunIsDrawnWithoutANetwork) {
  short_walks("one");
  ASSERT_EQ(gaitslam("report one/seed-1 --out one.html").exit_code, 0);
  const std::string page = text_of("one.html");
  EXPECT_THAT(page, Not(HasSubstr("<script src")));
  EXPECT_THAT(page, Not(HasSubstr("<link rel=\"stylesheet")));
  expect_all_drawn("one.html", 10);
  EXPECT_THAT(opened("one.html").out, HasSubstr("<code>tools/gaitslam view one/seed-1</code> and <code>#t="));
  walk("--without camera,slam limits.path_length_m.at_least=0.01 --out bare");
  ASSERT_EQ(gaitslam("report bare/seed-1 --out bare.html").exit_code, 0);
  expect_all_drawn("bare.html", 3);
  EXPECT_THAT(opened("bare.html").out, HasSubstr("<td class=\"good\">passed</td>"));
}

// A folder of scenarios with folders of seeds, as a suite writes it.
TEST_F(ReportTest, AFolderOfScenariosIsGroupedByScenario) {
  short_walks("suite/walk", "1 2");
  for (const std::string seed : {"seed-1", "seed-2"})
    ASSERT_EQ(gaitslam("replay suite/walk/" + seed + " name=other --out suite/other/" + seed).exit_code, 0);
  ASSERT_EQ(gaitslam("report suite --out suite.html").exit_code, 0);
  expect_all_drawn("suite.html", 10);
  const std::string page = text_of("suite.html"), shown = opened("suite.html").out;
  EXPECT_THAT(page, HasSubstr("<h1>other, walk: 4 runs</h1>"));
  EXPECT_THAT(shown, HasSubstr("<h2>other: all runs</h2>"));
  EXPECT_THAT(shown, HasSubstr("<h2>walk: all runs</h2>"));
  ASSERT_EQ(gaitslam("report suite/walk --out two.html").exit_code, 0);
  expect_all_drawn("two.html", 13);
  for (const char* part : {"<h1>walk: 2 runs</h1>", "error_over_seeds", "in the 95 % band: position "})
    EXPECT_THAT(text_of("two.html"), HasSubstr(part));
}

TEST_F(LongReportTest, ASweepHasAPageFromWhichItsWorstTrialCanBeRun) {
  ::setenv("GAITSLAM_CACHE", (folder_ / "cache").c_str(), 1);
  ASSERT_EQ(gaitslam("sweep walk.yaml slam.vision.sigma_px=1,3 --seeds 1,2 --out sweep").exit_code, 0);
  ::unsetenv("GAITSLAM_CACHE");
  const Ran ran = gaitslam("report sweep --out sweep.html");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const std::string page = text_of("sweep.html");
  EXPECT_THAT(page, HasSubstr("rmse_m over slam.vision.sigma_px"));
  EXPECT_THAT(opened("sweep.html").err, Not(HasSubstr("CONSOLE")));
  const std::string begin = "<pre>tools/gaitslam ";
  const std::size_t at = page.find(begin) + begin.size();
  EXPECT_EQ(gaitslam(page.substr(at, page.find("</pre>", at) - at) + " --out again").exit_code, 0);
  EXPECT_THAT(refusal("report sweep sweep --out x.html"), HasSubstr("sweep: is a sweep or a tuning"));
}

// The tab key reaches every control in the order of the page, with a visible focus; Enter sorts, arrows move
// the time and turn the map; a page printed from a dark screen is light, complete and without controls.
TEST_F(ReportTest, AKeyboardAndAPrinterAreEnough) {
  short_walks("many", "1 2 3");
  ASSERT_EQ(gaitslam("report many --out many.html").exit_code, 0);
  const Ran ran = shell("timeout 300 node " GAITSLAM_USE_REPORT " many.html profile");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto found = nlohmann::json::parse(ran.out);
  EXPECT_GT(found["keyboard"]["expected"].size(), 50u);
  EXPECT_EQ(found["keyboard"]["reached"], found["keyboard"]["expected"]);
  EXPECT_EQ(found["keyboard"]["unseen"], nlohmann::json::array());

  auto rising = found["sorted"]["before"].get<std::vector<double>>();
  std::sort(rising.begin(), rising.end());
  EXPECT_EQ(found["sorted"]["after_enter"], nlohmann::json(rising));
  std::reverse(rising.begin(), rising.end());
  EXPECT_EQ(found["sorted"]["after_another"], nlohmann::json(rising));

  EXPECT_LT(found["map"]["earlier_s"], found["map"]["last_s"]);
  EXPECT_TRUE(found["map"]["moved"]);
  EXPECT_TRUE(found["map"]["turned"]);

  const auto& pointed = found["pointed"];
  EXPECT_THAT(pointed["before"]["legend"].get<std::string>(), testing::ContainsRegex("error .*3 sigma"));
  EXPECT_THAT(pointed["before"]["legend"].get<std::string>(), Not(testing::ContainsRegex("error -?[0-9]")));
  EXPECT_THAT(pointed["under"]["legend"].get<std::string>(),
              testing::ContainsRegex("time .s.: .*error -?[0-9]"));
  EXPECT_THAT(pointed["clicked"]["instant"].get<std::string>(),
              testing::ContainsRegex("at [0-9.]+ s: tools/gaitslam view many/seed-1 and #t=[0-9.]+"));
  EXPECT_NE(pointed["clicked"]["instant"], pointed["before"]["instant"]);
  EXPECT_GT(pointed["zoomed"]["first"], pointed["before"]["first"]) << "a drag zooms";
  EXPECT_EQ(pointed["zoomed"]["first"], pointed["zoomed"]["other"]) << "all figures over time together";
  EXPECT_EQ(pointed["whole"]["first"], pointed["before"]["first"]) << "a double click shows all";
  EXPECT_LE(found["phone"].get<int>(), 400) << "the page fits a phone";

  EXPECT_EQ(found["print"]["background"], "rgb(255, 255, 255)");
  EXPECT_EQ(found["print"]["closed"], 0);
  for (const char* wrong : {"dark", "controls", "cut", "too_high"})
    EXPECT_EQ(found["print"][wrong], nlohmann::json::array()) << wrong;
}

TEST_F(ReportTest, ABrokenPageIsNoticed) {
  write("broken.html", "<html data-figures=\"1\"><script>throw new Error('planted')</script></html>");
  EXPECT_THAT(opened("broken.html").err, HasSubstr("CONSOLE"));
}

TEST_F(ReportTest, StillPicturesAppearTogether) {
  short_walks("two");
  const Ran ran = gaitslam("report two/seed-1 --plots svg,png --out figures");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(text_of("figures/error_x.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(text_of("figures/error_x.png").substr(1, 3), "PNG");
  EXPECT_EQ(gaitslam("report two/seed-1 --plots svg --out figures").exit_code, 2);
  EXPECT_EQ(gaitslam("report two/seed-1 --plots svg --out figures --force").exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "figures/error_x.png"));
}

// A picture without colors has three equal parts.
TEST_F(ReportTest, StillPicturesHaveColours) {
  short_walks("two");
  ASSERT_EQ(gaitslam("report two/seed-1 --plots png --out figures").exit_code, 0);
  const Ran ran = shell(
      "ffmpeg -v error -i figures/from_above.png -f rawvideo -pix_fmt rgb24 - | python3 -c 'import sys, "
      "collections; "
      "b = sys.stdin.buffer.read(); c = collections.Counter(zip(b[::3], b[1::3], b[2::3])); "
      "print(*(n for _, n in ((k, c[k]) for k in [(0xd5, 0x5e, 0), (0, 0x72, 0xb2), (0x33, 0x33, 0x33)])))'");
  std::istringstream counts(ran.out);
  for (const char* line : {"plan", "estimate", "truth"}) {
    int pixels = 0;
    counts >> pixels;
    EXPECT_GT(pixels, 100) << line << ": " << ran.err;
  }
}

TEST_F(ReportTest, ThePageTellsWhoSetEachKeyAndWhatWasLookedFor) {
  walk("slam.vision.sigma_px=1.5 --out one");
  ASSERT_EQ(gaitslam("report one/seed-1 --out one.html").exit_code, 0);
  const std::string page = text_of("one.html");
  EXPECT_THAT(page, HasSubstr("<code>slam.vision.sigma_px</code></td><td><code>1.5</code></td><td>px</td>"
                              "<td class='soft'>argument 1</td>"));
  EXPECT_THAT(page, HasSubstr("<td class='soft'>walk.yaml:"));
  EXPECT_THAT(page, HasSubstr("ellipse class='used'"));
  ASSERT_EQ(gaitslam("replay one/seed-1 --out again").exit_code, 0);
  EXPECT_EQ(text_of("again/about.json"), text_of("one/seed-1/about.json")) << "a replay knows it too";
}

// Text that closes an element, an attribute or a script, and a script that would mark the page with @. The
// last one hides the text after it.
constexpr std::array kPayloads{
    R"(</title><script>document.documentElement.dataset.@='1'</script>)",
    R"(</script><script>document.documentElement.dataset.@='1'</script>)",
    R"("><img src=x onerror="document.documentElement.dataset.@='1'">)",
    R"('><svg onload="document.documentElement.dataset.@='1'"></svg>)",
    R"(<iframe srcdoc="<script>parent.document.documentElement.dataset.@='1'</script>"></iframe>)",
    R"(&lt;script&gt;document.documentElement.dataset.@='1'&lt;/script&gt;)",
    R"(<!--<script>document.documentElement.dataset.@='1'</script>)"};

// The payloads from one to another, one after the other; the k-th marks the page as "ran<k>".
std::string payloads(std::size_t first, std::size_t end) {
  std::string all;
  for (std::size_t k = first; k < end; ++k) {
    const std::string payload = kPayloads[k];
    const std::size_t at = payload.find('@');
    all += payload.substr(0, at) + "ran" + std::to_string(k) + payload.substr(at + 1);
  }
  return all;
}

// An untrusted result: every text of it that a page shows is a payload.
TEST_F(ReportTest, NoTextOfAReceivedResultRunsAsAScript) {
  short_walks("one");
  auto score = nlohmann::json::parse(text_of("one/seed-1/score.json"));
  auto about = nlohmann::json::parse(text_of("one/seed-1/about.json"));
  const std::string payload = payloads(0, kPayloads.size());
  score["scenario"] = payload;
  for (auto& [name, metric] : score["metrics"].items()) metric["unit"] = metric["reason"] = payload;
  score["metrics"][payload] = {{"value", 1}, {"unit", payload}};
  score["limits"] =
      nlohmann::json::array({{{"metric", payload}, {"at_most", 1}, {"value", 1}, {"passed", true}}});
  for (const char* key : {"program", "version", "revision", "cause"}) about[key] = payload;
  for (auto& [key, by] : about["set_by"].items()) by = payload;
  write("one/seed-1/score.json", score.dump());
  write("one/seed-1/about.json", about.dump());
  shell("cp -r one/seed-1 one/seed-2");
  ASSERT_EQ(gaitslam("report one/seed-1 --out one.html").exit_code, 0);
  ASSERT_EQ(gaitslam("report one --out two.html").exit_code, 0);
  for (const char* page : {"one.html", "two.html"}) {
    const Ran ran = opened(page);
    EXPECT_THAT(ran.out, Not(HasSubstr("data-ran"))) << page;
    EXPECT_THAT(ran.out, HasSubstr("data-drawn=")) << page << ": the page itself is whole";
    EXPECT_THAT(ran.err, Not(HasSubstr("CONSOLE"))) << page << ": nothing had to be blocked";
  }
}

// Even if a text were written unescaped, the browser would run no script but the page's.
TEST_F(ReportTest, ThePolicyOfAPageBlocksWhatEscapingMissed) {
  short_walks("one");
  ASSERT_EQ(gaitslam("report one/seed-1 --out one.html").exit_code, 0);
  std::string page = text_of("one.html");
  page.insert(page.find("<body>") + 6, payloads(0, 5));
  write("with.html", page);
  const Ran with = opened("with.html");
  EXPECT_THAT(with.out, Not(HasSubstr("data-ran")));
  EXPECT_THAT(with.out, HasSubstr("data-drawn=")) << "the page itself is whole";
  EXPECT_THAT(with.err, HasSubstr("Content Security Policy"));
  const std::size_t policy = page.find("<meta http-equiv");
  write("without.html", page.erase(policy, page.find("\n", policy) - policy));
  const Ran without = opened("without.html");
  for (int k = 0; k < 5; ++k)
    EXPECT_THAT(without.out, HasSubstr("data-ran" + std::to_string(k)))
        << kPayloads[static_cast<std::size_t>(k)];
}

TEST_F(ReportTest, PicturesOfAnEditedRecordingAreNotPutIntoAPage) {
  short_walks("one");
  write("secret.png", "secret");
  const std::string rows = "one/seed-1/recording/mav0/cam0/data.csv";
  const std::string names = text_of(rows);
  const std::size_t first = names.find(',', names.find('\n')) + 1, end = names.find('\n', first);
  write(rows, std::string(names).replace(first, end - first, "../../../../../../secret.png"));
  EXPECT_THAT(refusal("report one --out x.html"), HasSubstr("data.csv"));
  write(rows, names);
  const std::string picture = "one/seed-1/recording/mav0/cam0/data/" + names.substr(first, end - first);
  std::filesystem::remove(folder_ / picture);
  std::filesystem::create_symlink(folder_ / "secret.png", folder_ / picture);
  EXPECT_THAT(refusal("report one --out x.html"), HasSubstr("leads out of the folder"));
  std::filesystem::remove(folder_ / picture);
  write(picture, "secret");
  EXPECT_THAT(refusal("report one --out x.html"), HasSubstr(picture));
}

TEST_F(ReportTest, WhatIsNoResultIsNamed) {
  short_walks("two");
  const auto complaint = [&](const std::string& arguments) { return refusal("report " + arguments); };
  EXPECT_THAT(complaint("nowhere --out x.html"), HasSubstr("nowhere: no such result folder"));
  std::filesystem::create_directory(folder_ / "empty");
  EXPECT_THAT(complaint("empty --out x.html"), HasSubstr("expected a result folder"));
  EXPECT_THAT(complaint("two --plots gif --out x"), HasSubstr("gif"));
  EXPECT_THAT(complaint("two"), HasSubstr("--out"));
  write("two/seed-1/frames.csv", "a,b\n1\n");
  EXPECT_THAT(complaint("two --out x.html"), HasSubstr("frames.csv:2: expected 2 fields, found 1"));
  write("two/seed-1/frames.csv", "a,a\n1,1\n");
  EXPECT_THAT(complaint("two --out x.html"), HasSubstr("frames.csv:1: has the column 'a' twice"));
  write("two/seed-1/score.json", R"({"scenario": 5})");
  EXPECT_THAT(complaint("two --out x.html"), HasSubstr("score.json: scenario: expected text, found number"));
  write("two/seed-1/score.json", "{");
  EXPECT_THAT(complaint("two --out x.html"), HasSubstr("score.json: expected a JSON object"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.html"));
}

}  // namespace
