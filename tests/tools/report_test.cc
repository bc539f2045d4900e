// Reports through the program, opened in a browser as a reader does.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <vector>

#include "tests/tools/command_line.h"

namespace {

using testing::HasSubstr;
using testing::Not;
using tests::Ran;

class ReportTest : public tests::CommandLine {
 protected:
  ReportTest() { write("walk.yaml", tests::kShortWalk); }
  void walk(const std::string& arguments) { ASSERT_EQ(gaitslam("run walk.yaml " + arguments).exit_code, 0); }

  // What the page is after its script ran. Names are resolved nowhere: what is not in the file is not there.
  Ran opened(const std::string& page) const {
    return shell(
        "timeout 100 chromium --headless --no-sandbox --user-data-dir=profile --use-angle=swiftshader "
        "--enable-unsafe-swiftshader --host-resolver-rules='MAP * ~NOTFOUND' --enable-logging=stderr "
        "--window-size=1200,900 --virtual-time-budget=10000 --dump-dom \"file://$PWD/" +
        page + "\"");
  }
  void expect_all_drawn(const std::string& page, int at_least) const {
    const Ran ran = opened(page);
    std::smatch figures, drawn;
    ASSERT_TRUE(std::regex_search(ran.out, figures, std::regex("data-figures=\"(\\d+)\""))) << ran.err;
    ASSERT_TRUE(std::regex_search(ran.out, drawn, std::regex("data-drawn=\"(\\d+)\""))) << ran.err;
    EXPECT_EQ(figures[1], drawn[1]);
    EXPECT_GE(std::stoi(drawn[1]), at_least);
    EXPECT_THAT(ran.err, Not(HasSubstr("CONSOLE"))) << "the page said something on the browser's console";
  }
};

TEST_F(ReportTest, EveryFigureOfARunIsDrawnWithoutANetwork) {
  walk("--out one");
  ASSERT_EQ(gaitslam("report one/seed-1 --out one.html").exit_code, 0);
  const std::string page = text_of("one.html");
  EXPECT_THAT(page, Not(HasSubstr("<script src")));
  EXPECT_THAT(page, Not(HasSubstr("<link rel=\"stylesheet")));
  expect_all_drawn("one.html", 10);
}

TEST_F(ReportTest, SeveralRunsAreComparedOnOnePage) {
  walk("--seeds 1,2 --out two");
  ASSERT_EQ(gaitslam("report two --out two.html").exit_code, 0);
  expect_all_drawn("two.html", 13);
  EXPECT_THAT(text_of("two.html"), HasSubstr("error_over_seeds"));
  EXPECT_THAT(text_of("two.html"), HasSubstr(R"("title":"walk: 2 runs")"));
  EXPECT_THAT(text_of("two.html"), HasSubstr("within the 95 % band: position "));
}

TEST_F(ReportTest, AWalkWithoutFilterHasAReportToo) {
  walk("--without camera,slam --out bare");
  ASSERT_EQ(gaitslam("report bare/seed-1 --out bare.html").exit_code, 0);
  expect_all_drawn("bare.html", 3);
}

// Every control is reached by the tab key in the order of the page, with its focus seen; Enter sorts, arrows
// move the time and turn the map; what a dark screen prints is light, whole and without controls.
TEST_F(ReportTest, AKeyboardAndAPrinterAreEnough) {
  walk("--seeds 1..3 --out many");
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
  walk("--out two");
  const Ran ran = gaitslam("report two/seed-1 --plots svg,png --out figures");
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_THAT(text_of("figures/error_x.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(text_of("figures/error_x.png").substr(1, 3), "PNG");
  EXPECT_EQ(gaitslam("report two/seed-1 --plots svg --out figures").exit_code, 2);
  EXPECT_EQ(gaitslam("report two/seed-1 --plots svg --out figures --force").exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "figures/error_x.png"));
}

// The grey of a picture that knows no colours has three equal parts.
TEST_F(ReportTest, StillPicturesHaveColours) {
  walk("--out two");
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
  EXPECT_THAT(page,
              HasSubstr(R"("key":"slam.vision.sigma_px","value":"1.5","unit":"px","origin":"argument 1")"));
  EXPECT_THAT(page, HasSubstr(R"("origin":"walk.yaml:)"));
  EXPECT_THAT(page, HasSubstr("ellipse class='used'"));
  ASSERT_EQ(gaitslam("replay one/seed-1 --out again").exit_code, 0);
  EXPECT_EQ(text_of("again/about.json"), text_of("one/seed-1/about.json")) << "a replay knows it too";
}

TEST_F(ReportTest, SeedsOfABatchTellWhoSetTheirKeys) {
  walk("slam.vision.sigma_px=1.5 --seeds 2 --out many");
  EXPECT_THAT(text_of("many/seed-2/about.json"), HasSubstr(R"("slam.vision.sigma_px": "argument 1")"));
}

TEST_F(ReportTest, WhatIsNoResultIsNamed) {
  walk("--out two");
  const auto complaint = [&](const std::string& arguments) { return refusal("report " + arguments); };
  EXPECT_THAT(complaint("nowhere --out x.html"), HasSubstr("nowhere: no such result folder"));
  EXPECT_THAT(complaint(". --out x.html"), HasSubstr("expected a result folder"));
  EXPECT_THAT(complaint("two --plots gif --out x"), HasSubstr("gif"));
  EXPECT_THAT(complaint("two"), HasSubstr("--out"));
  write("two/seed-1/frames.csv", "a,b\n1\n");
  EXPECT_THAT(complaint("two --out x.html"), HasSubstr("frames.csv:2: expected 2 fields, found 1"));
  write("two/seed-1/score.json", "{");
  EXPECT_THAT(complaint("two --out x.html"), HasSubstr("score.json: expected a JSON object"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.html"));
}

}  // namespace
