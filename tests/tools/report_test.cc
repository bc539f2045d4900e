// Reports made by the program and opened in a browser, and the paper's experiments with one command.
#include "tests/tools/command_line.h"

namespace tests {
namespace {

class ReportTest : public CommandLine {
 protected:
  /// The page after its script has run; on standard error, the browser's console. No host name resolves.
  Ran opened(const std::string& page) const {
    return shell(
        "timeout 100 chromium --headless --no-sandbox --user-data-dir=profile --use-angle=swiftshader "
        "--enable-unsafe-swiftshader --host-resolver-rules='MAP * ~NOTFOUND' --enable-logging=stderr "
        "--window-size=1200,900 --virtual-time-budget=10000 --dump-dom \"file://$PWD/" +
        page + "\"");
  }
  /// The page after its script has run, with all of its figures.
  std::string drawn(const std::string& page, int at_least) const {
    const Ran ran = opened(page);
    const auto number = [&](const std::string& attribute) {
      const std::size_t at = ran.out.find(attribute + "=\"");
      return at == ran.out.npos ? -1 : std::atoi(ran.out.c_str() + at + attribute.size() + 2);
    };
    EXPECT_EQ(number("data-figures"), number("data-drawn")) << ran.err;
    EXPECT_GE(number("data-drawn"), at_least) << ran.err;
    EXPECT_THAT(ran.err, Lacks("CONSOLE")) << "the browser's console is not empty";
    return ran.out;
  }
};
using LongReportTest = ReportTest;

TEST_F(ReportTest, EveryFigureOfARunIsDrawnWithoutANetwork) {
  short_walks("one");
  ok("report one/seed-1 --out one.html");
  EXPECT_THAT(text_of("one.html"),
              AllOf(Has("ellipse class='used'"), Lacks("<script src", "<link rel=\"stylesheet")));
  EXPECT_THAT(drawn("one.html", 10), Has("<pre>tools/gaitslam view one/seed-1</pre>"));
  ok("run walk.yaml --without camera,slam world.seed=2 limits.path_length_m.at_least=0.01 --out bare");
  ok("report bare/seed-1 --out bare.html");
  EXPECT_THAT(text_of("bare.html"), Has("<td class='soft'>argument 1</td>", "<td class='soft'>walk.yaml:"));
  EXPECT_THAT(drawn("bare.html", 3), Has("<td class=\"good\">passed</td>"));
}

// A folder of scenarios with folders of seeds, as written by a suite.
TEST_F(ReportTest, AFolderOfScenariosIsGroupedByScenario) {
  short_walks("suite/walk", "1 2");
  for (const std::string seed : {"seed-1", "seed-2"})
    ok("replay suite/walk/" + seed + " name=other --out suite/other/" + seed);
  ok("report suite --out suite.html");
  EXPECT_THAT(drawn("suite.html", 10),
              Has("<h1>other, walk: 4 runs</h1>", "<h2>other: all runs</h2>", "<h2>walk: all runs</h2>"));
  ok("report suite/walk --out two.html");
  drawn("two.html", 13);
  EXPECT_THAT(text_of("two.html"),
              Has("<h1>walk: 2 runs</h1>", "error_over_time", "within the 95 % band: position "));
}

TEST_F(ReportTest, ResultsNamedByAnAbsolutePathAreShownWithARelativeOneAndSeedsFitInTwoMegabytes) {
  short_walks("walk", "1 2 3");
  ok("report \"$PWD/walk\" \"$PWD/walk/seed-1\" --out three.html");
  EXPECT_THAT(text_of("three.html"),
              AllOf(Has("tools/gaitslam view walk/seed-", "for the other 2"), Lacks(folder_.string())));
  EXPECT_LT(text_of("three.html").size(), 2'000'000u);
}

TEST_F(LongReportTest, ASweepHasAPageFromWhichItsWorstTrialCanBeRun) {
  ok("sweep walk.yaml slam.vision.sigma_px=1,3 --seeds 1,2 --out sweep");
  ok("report sweep --out sweep.html");
  const std::string page = text_of("sweep.html"), begin = "<pre>tools/gaitslam ";
  EXPECT_THAT(page, Has("rmse_m over slam.vision.sigma_px"));
  EXPECT_THAT(opened("sweep.html").err, Lacks("CONSOLE"));
  const std::size_t at = page.find(begin) + begin.size();
  ok(page.substr(at, page.find("</pre>", at) - at) + " --out again");
  expect_refused("report sweep sweep --out x.html", "sweep: is a sweep or tuning");
}

// The tab key reaches every control in page order, with a visible focus. A page printed from a dark screen is
// light, complete and without controls.
TEST_F(ReportTest, AKeyboardAndAPrinterAreEnough) {
  short_walks("many", "1 2 3");
  ok("report many --out many.html");
  const auto found =
      json::parse(shell("timeout 300 node " + kSources + "/tests/tools/use_page.cjs report many.html profile")
                      .ends(0)
                      .out);
  EXPECT_GT(found["keyboard"]["expected"].size(), 30u);
  EXPECT_EQ(found["keyboard"]["reached"], found["keyboard"]["expected"]);
  EXPECT_EQ(found["keyboard"]["unseen"], json::array());

  const auto& [before, after] = std::pair(found["scatter"]["before"], found["scatter"]["after"]);
  EXPECT_THAT(before["title"].get<std::string>(), Has("RMSE [mm] over ATE [mm]"));
  EXPECT_THAT(after["title"].get<std::string>(), Has("ATE Sim(3) [mm] over ATE [mm]"));
  EXPECT_NE(before["dots"], after["dots"]);
  const std::string dots = before["dots"][0];
  EXPECT_EQ(std::ranges::count(dots, 'M'), 3) << "a dot for each run";

  const auto& pointed = found["pointed"];
  EXPECT_THAT(pointed["before"]["legend"].get<std::string>(),
              AllOf(ContainsRegex("error .*3 sigma"), Not(ContainsRegex("error -?[0-9]"))));
  EXPECT_THAT(pointed["under"]["legend"].get<std::string>(), ContainsRegex("time .s.: .*error -?[0-9]"));
  EXPECT_GT(pointed["zoomed"]["first"], pointed["before"]["first"]) << "a drag zooms";
  EXPECT_EQ(pointed["zoomed"]["first"], pointed["zoomed"]["other"]) << "all figures over time together";
  EXPECT_EQ(pointed["whole"]["first"], pointed["before"]["first"]) << "a double click shows all";
  EXPECT_LE(found["phone"].get<int>(), 400) << "the page fits a phone";

  EXPECT_EQ(found["print"]["background"], "rgb(255, 255, 255)");
  EXPECT_EQ(found["print"]["closed"], 0);
  for (const char* wrong : {"dark", "controls", "cut", "too_high"})
    EXPECT_EQ(found["print"][wrong], json::array()) << wrong;
}

TEST_F(ReportTest, ABrokenPageIsDetected) {
  write("broken.html", "<html data-figures=\"1\"><script>throw new Error('planted')</script></html>");
  EXPECT_THAT(opened("broken.html").err, Has("CONSOLE"));
}

TEST_F(ReportTest, StillPicturesAppearTogetherAndHaveColors) {
  short_walks("two");
  ok("report two/seed-1 --plots svg --out figures");
  EXPECT_THAT(text_of("figures/error_x.svg"), Has("</svg>"));
  for (const char* color : {"#d55e00", "#0072b2", "#333"})  // colors of plan, estimate and truth
    EXPECT_THAT(text_of("figures/from_above.svg"), Has(color));
  EXPECT_EQ(gaitslam("report two/seed-1 --plots svg --out figures").exit_code, 2);
  ok("report two/seed-1 --plots svg --width-mm 88 --no-titles --out figures --force");
  const std::string narrow = text_of("figures/error_x.svg");
  EXPECT_THAT(narrow, AllOf(Has("width='333'"), Lacks("class='title'")));  // px, 96 per inch
  EXPECT_EQ(gaitslam("report two/seed-1 --width-mm 88 --out x.html").exit_code, 2)
      << "only pictures have a width";
  expect_refused("report two/seed-1 --plots svg --width-mm 10 --out x", "--width-mm");
  ok("report two/seed-1 --plots pdf --width-mm 88 --out pdf");
  EXPECT_THAT(text_of("pdf/error_x.pdf"), StartsWith("%PDF-"));
  EXPECT_FALSE(fs::exists(folder_ / "pdf/error_x.svg"));
  const Ran without =
      shell("PATH=/nothing '" GAITSLAM_PROGRAM "' report two/seed-1 --plots pdf --out none").ends(2);
  EXPECT_THAT(without.err, StartsWith("gaitslam: --plots pdf: rsvg-convert is missing"));
  EXPECT_EQ(std::ranges::count(without.err, '\n'), 1);
  EXPECT_FALSE(fs::exists(folder_ / "none"));
}

// Text that closes an element, an attribute or a script, and a script that would mark the page.
const std::string kMark = "document.documentElement.dataset.ran",
                  kPayload = "</title><script>" + kMark + "0='1'</script></script><script>" + kMark +
                             "1='1'</script>\"><img src=x onerror=\"" + kMark + "2='1'\">'><svg onload=\"" +
                             kMark + "3='1'\"></svg><iframe srcdoc=\"<script>parent." + kMark +
                             "4='1'</script>\"></iframe>",
                  kHiding = "&lt;script&gt;" + kMark + "5='1'&lt;/script&gt;<!--<script>" + kMark +
                            "6='1'</script>";  // hides the text after it

// An untrusted result: each of its texts that a page shows is a payload.
TEST_F(ReportTest, NoTextOfAReceivedResultRunsAsAScript) {
  short_walks("one");
  auto score = json_in("one/seed-1/score.json");
  auto about = json_in("one/seed-1/about.json");
  const std::string payload = kPayload + kHiding;
  score["scenario"] = payload;
  for (auto& [name, metric] : score["metrics"].items()) metric["unit"] = metric["reason"] = payload;
  score["metrics"][payload] = {{"value", 1}, {"unit", payload}};
  score["limits"] = json::array({{{"metric", payload}, {"at_most", 1}, {"value", 1}, {"passed", true}}});
  for (const char* key : {"program", "version", "revision", "cause"}) about[key] = payload;
  for (auto& [key, by] : about["set_by"].items()) by = payload;
  write("one/seed-1/score.json", score.dump());
  write("one/seed-1/about.json", about.dump());
  shell("cp -r one/seed-1 one/seed-2");
  ok("report one/seed-1 --out one.html");
  ok("report one --out two.html");
  for (const char* page : {"one.html", "two.html"}) {
    const Ran ran = opened(page);
    EXPECT_THAT(ran.out, Lacks("data-ran")) << page;
    EXPECT_THAT(ran.out, Has("data-drawn=")) << page << ": the page itself is whole";
    EXPECT_THAT(ran.err, Lacks("CONSOLE")) << page << ": nothing had to be blocked";
  }
}

TEST_F(ReportTest, AFolderThatIsNotAResultIsReported) {
  short_walks("two");
  fs::create_directory(folder_ / "empty");
  expect_refused({{"report nowhere --out x.html", "nowhere: no such result folder"},
                  {"report empty --out x.html", "expected a result folder"},
                  {"report two --plots gif --out x", "gif"},
                  {"report two --out x.pdf", "--out x.pdf: expected a name ending in .html"},
                  {"report two", "--out"}});
  const std::string frames = text_of("two/seed-1/frames.csv");
  for (const auto& [file, text, complaint] :
       {std::array<std::string, 3>{"frames.csv", frames + "1\n", "fields, found 1"},
        {"frames.csv", frames.substr(0, frames.find('\n')) + ",timestamp\n",
         ":1: has a duplicate column 'timestamp'"},
        {"score.json", "{", ":1:2: is not JSON or is cut off here"}}) {
    write("two/seed-1/" + file, text);
    EXPECT_THAT(refusal("report two --out x.html"), AllOf(Has(file), Has(complaint)));
  }
}

const std::string kBlindWalk = "walk: {commands: [" + kStep + "]}\n";
class ReproduceTest : public CommandLine {
 protected:
  ReproduceTest() { write_experiments(kBlindWalk); }
  void write_experiments(const std::string& walk) const {
    const std::string filter = walk + "camera: {}\nslam: {}\n",
                      lines = walk + "camera: {}\nslam: {depth: {first_sight: particles}}\n";
    for (const char* name : {"tangent_quadrant", "perpendicular_circle_trial1"})
      write(std::string("s/") + name + ".yaml", walk);
    for (const char* name : {"tangent_circle", "perpendicular_circle", "hall"})
      write(std::string("s/") + name + ".yaml", filter);
    for (const char* name : {"tangent_circle_paper", "vision_only", "vision_gyro_known_landmarks",
                             "perpendicular_circle_paper", "hall_paper"})
      write(std::string("s/") + name + ".yaml", lines);
  }
  Ran reproduce(const std::string& arguments = "--out out") const {
    return gaitslam("reproduce --scenarios s --seeds 3 --jobs 2 " + arguments);
  }
  auto made(const std::string& experiment) const {
    return fs::last_write_time(folder_ / "out" / experiment / "seed-3/score.json");
  }
};
using LongReproduceTest = ReproduceTest;

TEST_F(LongReproduceTest, RunsAllExperimentsOnceAndContinuesWhereItWasStopped) {
  const Ran first = reproduce().ends(0);
  EXPECT_EQ(first.complaints(), "") << "no progress line without a terminal";
  EXPECT_THAT(first.out, AllOf(Has("page in out/index.html"), Lacks("not run")));
  EXPECT_THAT(text_of("out/index.html"),
              Has("Figure 1", "Figure 4", "Figure 6", "Figure 7", "Figure 8", "<ellipse"));

  const auto walked = made("tangent_circle"), replayed = made("vision_only");
  fs::remove_all(folder_ / "out/hall_paper/seed-3");
  write("s/vision_only.yaml", kBlindWalk + "camera: {}\nslam: {gyro: {enabled: false}}\n");
  EXPECT_THAT(reproduce().ends(2).err, Has("out/vision_only/seed-3: exists, but "));
  reproduce("--out out --force").ends(0);
  EXPECT_EQ(made("tangent_circle"), walked) << "it was complete";
  EXPECT_NE(made("vision_only"), replayed) << "its scenario has changed";
  EXPECT_THAT(text_of("out/hall_paper/seed-3/depths.csv"), Has("probability"));
}

TEST_F(ReproduceTest, ErrorsAreReportedBeforeAnythingIsRun) {
  fs::remove(folder_ / "s/hall.yaml");
  expect_refused({{"reproduce --out out --seeds 3..1 --scenarios s", "3..1"},
                  {"reproduce --out out --scenarios s", "s/hall.yaml: cannot be read"}});
}

}  // namespace
}  // namespace tests
