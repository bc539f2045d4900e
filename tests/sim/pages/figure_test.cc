#include "sim/pages/figure.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "sim/files/text.h"
#include "sim/pages/run_figures.h"
#include "tests/sim/files/temporary_folder.h"

namespace {

using namespace sim::pages;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

Figure one_line(std::vector<double> x, std::vector<double> y) {
  Figure figure{"name", "Title", "x [m]", "y [m]"};
  figure.lines.push_back({"truth", Role::truth, std::move(x), std::move(y)});
  return figure;
}

TEST(Axis, TicksAreMultiplesOfOneTwoOrFiveInsideTheRange) {
  const auto near = [](double v) { return DoubleNear(v, 1e-12); };
  EXPECT_THAT((Axis{0.13, 0.98}.ticks(5)), ElementsAre(near(0.2), near(0.4), near(0.6), near(0.8)));
  EXPECT_THAT((Axis{-7, 7}.ticks(4)), ElementsAre(near(-5), near(0), near(5)));
}

TEST(Axis, TicksOfALogarithmAreDecades) {
  const Axis axis{0.02, 150, 0, 1, true};
  EXPECT_THAT(axis.ticks(5), ElementsAre(DoubleNear(0.1, 1e-12), DoubleNear(1, 1e-12), DoubleNear(10, 1e-9),
                                         DoubleNear(100, 1e-9)));
  EXPECT_NEAR(axis.at(0.02), 0, 1e-12);
  EXPECT_NEAR(axis.at(150), 1, 1e-12);
  EXPECT_GE((Axis{2.1, 4.9, 0, 1, true}.ticks(5).size()), 2u) << "without a power of ten in it";
}

TEST(Axis, TicksAreShortNumbersOrPowersOfTen) {
  EXPECT_EQ(tick_text(0), "0");
  EXPECT_EQ(tick_text(0.001), "0.001");
  EXPECT_EQ(tick_text(12500), "12500");
  EXPECT_EQ(tick_text(1e-5), "10\u207b\u2075");
  EXPECT_EQ(tick_text(9e-5), "9\u00b710\u207b\u2075");
  EXPECT_EQ(tick_text(-2e6), "-2\u00b710\u2076");
}

TEST(Axis, CountsHaveWholeTicks) {
  Axis axis{0.9, 3.1};
  axis.whole = true;
  EXPECT_THAT(axis.ticks(8), ElementsAre(1, 2, 3));
}

TEST(Axis, HoldsAllFiniteValuesAndSurvivesNone) {
  const std::vector<double> values{2, NAN, 5, INFINITY}, none{NAN};
  const Axis axis = axis_of({&values}, false);
  EXPECT_LT(axis.low, 2);
  EXPECT_GT(axis.high, 5);
  EXPECT_LT(axis.high, 6);
  EXPECT_LT(axis_of({&none}, false).low, axis_of({&none}, false).high);
}

RunData run_of(const Column& nees_position, const Column& nees_orientation) {
  RunData run;
  run.errors.emplace();
  run.errors->t = {1, 6, 7, 8};
  run.errors->distance = {0, 0, 0, 0};
  run.errors->nees_position = nees_position;
  run.errors->nees_orientation = nees_orientation;
  return run;
}

// Two runs: the mean is in its band from 0.62 to 7.22; the first second does not count.
TEST(ComparisonFigures, GiveTheShareOfFramesWithTheMeanNeesInItsBand) {
  const auto figures =
      comparison_figures({run_of({9, 3, 0.1, 9}, {1, 1, 1, 1}), run_of({9, 3, 0.2, 9}, {1, 1, 1, NAN})});
  ASSERT_EQ(figures.size(), 3u);
  const Figure& nees = figures[2];
  EXPECT_THAT(nees.title, HasSubstr("position 33 % (below it 33 %), orientation 100 % (below it 0 %)"));
  EXPECT_THAT(nees.lines.at(0).y, ElementsAre(9, 3, DoubleNear(0.15, 1e-12), 9));
  EXPECT_NEAR(nees.levels.at(0).y, 0.62, 0.005);
  EXPECT_NEAR(nees.levels.at(1).y, 7.22, 0.005);
}

TEST(Svg, NotANumberBreaksALine) {
  const std::string whole = to_svg(one_line({0, 1, 2, 3}, {0, 1, 2, 3}), 400, 300);
  const std::string broken = to_svg(one_line({0, 1, 2, 3}, {0, NAN, 2, 3}), 400, 300);
  const auto strokes = [](const std::string& svg) {
    const std::size_t line = svg.find(" d='", svg.find("class='line"));
    const std::string path = svg.substr(line, svg.find("/>", line) - line);
    return std::count(path.begin(), path.end(), 'M');
  };
  EXPECT_EQ(strokes(whole), 1);
  EXPECT_EQ(strokes(broken), 2);
}

TEST(Svg, TextEndsNeitherAnElementNorAnAttribute) {
  Figure figure = one_line({0, 1}, {0, 1});
  figure.title = "a < b & c's";
  EXPECT_THAT(to_svg(figure, 400, 300), HasSubstr(">a &lt; b &amp; c&#39;s<"));
  EXPECT_THAT(to_svg(figure, 400, 300), HasSubstr("aria-label='a &lt; b &amp; c&#39;s'"));
}

TEST(Svg, AColorIsThereForProgramsWithoutVariablesAndForThePageAroundIt) {
  EXPECT_THAT(to_svg(one_line({0, 1}, {0, 1}), 400, 300),
              HasSubstr("{stroke:#0072b2;stroke:var(--estimate,#0072b2)}"));
}

TEST(Svg, ATitleAndALegendThatDoNotFitInALineAreBelowEachOther) {
  Figure figure = one_line({0, 1}, {0, 1});
  const std::string beside = to_svg(figure, 300, 300);
  EXPECT_THAT(beside, HasSubstr("y='18.0' class='title'>Title</text>"));
  EXPECT_THAT(beside, HasSubstr("y='18.0' >truth</text>"));
  figure.title = "A title that is as long as those of some of the figures of a report";
  const std::string below = to_svg(figure, 300, 300);
  EXPECT_THAT(below, HasSubstr("y='18.0' class='title'>A title that is as long as those of</text>"));
  EXPECT_THAT(below, HasSubstr("y='36.0' class='title'>some of the figures of a report</text>"));
  EXPECT_THAT(below, HasSubstr("y='54.0' >truth</text>"));
  EXPECT_THAT(below, HasSubstr("<rect class='frame' x='62.0' y='66.0'"));
}

TEST(Svg, EqualAxesGiveAMeterTheSameLengthBothWays) {
  Figure figure = one_line({0, 4}, {0, 1});
  figure.equal_axes = true;
  const std::string svg = to_svg(figure, 500, 500);
  const std::size_t path = svg.find("d='M", svg.find("class='line"));
  double x0, y0, x1, y1;
  ASSERT_EQ(std::sscanf(svg.c_str() + path, "d='M%lf %lfL%lf %lf'", &x0, &y0, &x1, &y1), 4);
  EXPECT_NEAR((x1 - x0) / 4, y0 - y1, 0.1) << "pixels are printed with one decimal";
}

// Values 1 to 5: the box reaches from 2 to 4.
TEST(Svg, ABoxReachesFromTheFirstToTheThirdQuartile) {
  Figure figure{"boxes", "Boxes", "", "mm"};
  figure.boxes = {{"filter", Role::estimate, {5, 1, 2, 4, 3}}, {"other", Role::first, {}}};
  const std::string svg = to_svg(figure, 400, 300);
  const Axis axis = [] {
    const std::vector<double> values{1, 5};
    Axis made = axis_of({&values}, false);
    made.begin = 300 - 46, made.end = 30;
    return made;
  }();
  EXPECT_THAT(svg, HasSubstr(fmt::format(" y='{:.1f}' width=", axis.at(4))));
  EXPECT_THAT(svg, HasSubstr(fmt::format("height='{:.1f}'/>", axis.at(2) - axis.at(4))));
  EXPECT_THAT(svg, HasSubstr(">other</text>")) << "an estimator without a value is named too";
}

RunData seed_of_estimator(const char* estimator, int seed, double ate_m) {
  RunData run = run_of({1, 1, 1, 1}, {1, 1, 1, 1});
  run.folder = fmt::format("{}/seed-{}", estimator, seed);
  run.scenario = "hall", run.estimator = estimator, run.seed = static_cast<std::uint64_t>(seed);
  run.metrics = {{"ate_se3_rmse_m", "m", "", ate_m}};
  return run;
}

TEST(ComparisonFigures, SeveralSeedsOfEstimatorsAreBoxes) {
  std::vector<RunData> runs;
  for (const char* estimator : {"filter", "plan"})
    for (const int seed : {1, 2}) runs.push_back(seed_of_estimator(estimator, seed, 0.001 * seed));
  const std::vector<Figure> figures = comparison_figures(runs);
  const auto found = std::find_if(figures.begin(), figures.end(),
                                  [](const Figure& f) { return f.name == "ate_boxes_hall"; });
  ASSERT_NE(found, figures.end());
  ASSERT_EQ(found->boxes.size(), 2u);
  EXPECT_EQ(found->boxes[1].name, "plan");
  EXPECT_THAT(found->boxes[0].values, ElementsAre(DoubleNear(1, 1e-9), DoubleNear(2, 1e-9)));
  EXPECT_THAT(found->runs, ElementsAre("filter/seed-1", "filter/seed-2", "plan/seed-1", "plan/seed-2"));
}

// Steps 2 m apart are corrected by at most 4 mm: 100 times that is a fifth of the walk, 200 times more than a
// quarter.
TEST(WaistFromAbove, CorrectionsAreDrawnAsLargeAsCanBeReadAndTheLegendSaysHowMuch) {
  const sim::files::TemporaryFolder folder;
  const auto file = folder / "corrected_steps.csv";
  const auto arrows = [&](double corrected_m) {
    sim::files::write_text(
        file, fmt::format("#expected_x [m],expected_y [m],expected_yaw [rad],ahead [m],aside [m]\n"
                          "0,0,0,{},0\n2,0,0,0.001,0\n",
                          corrected_m));
    RunData run;
    run.corrected_steps.emplace(file);
    return waist_from_above(run).lines.back();
  };
  EXPECT_EQ(arrows(0.004).name, "corrections, 100 times as large");
  EXPECT_NEAR(arrows(0.004).x.at(1), 0.4, 1e-12);
  EXPECT_EQ(arrows(0.5).name, "corrections");
  EXPECT_NEAR(arrows(0.5).x.at(1), 0.5, 1e-12);
}

// web/figures.js reads values under the cursor from the axes and the named paths.
TEST(PageSvg, HasItsAxesAndTheNamesOfItsLines) {
  Figure figure = one_line({0, 10}, {1, 100});
  figure.x_label = "time [s]", figure.logarithmic = true;
  const std::string svg = to_page_svg(figure, 400, 300);
  EXPECT_THAT(svg, testing::ContainsRegex("data-x='-0.5 10.5 62 386 0' data-y='0.6[0-9]* 150 254 12 1' "
                                          "data-over-time='yes'"));
  EXPECT_THAT(svg, HasSubstr("data-name='truth'"));
  EXPECT_THAT(svg, Not(HasSubstr("<style")));
}

}  // namespace
