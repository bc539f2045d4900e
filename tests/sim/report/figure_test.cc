#include "sim/report/figure.h"

#include <gmock/gmock.h>

#include <cmath>

#include "sim/report/axis.h"
#include "sim/report/bundle.h"
#include "sim/report/page.h"
#include "sim/report/page_data.h"
#include "sim/report/pictures.h"
#include "sim/report/run_figures.h"

namespace {

using namespace sim::report;
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
TEST(BatchFigures, SayInHowManyFramesTheMeanNeesIsInItsBand) {
  const auto figures =
      batch_figures({run_of({9, 3, 0.1, 9}, {1, 1, 1, 1}), run_of({9, 3, 0.2, 9}, {1, 1, 1, NAN})});
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
    const std::size_t line = svg.find("class='line");
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

TEST(Svg, AColourIsThereForReadersWithoutVariablesAndForThePageAroundIt) {
  EXPECT_THAT(to_svg(one_line({0, 1}, {0, 1}), 400, 300),
              HasSubstr(".line.estimate{stroke:#0072b2;stroke:var(--estimate,#0072b2)}"));
}

TEST(Svg, EqualAxesGiveAMetreTheSameLengthBothWays) {
  Figure figure = one_line({0, 4}, {0, 1});
  figure.equal_axes = true;
  const std::string svg = to_svg(figure, 500, 500);
  const std::size_t path = svg.find("d='M", svg.find("class='line"));
  double x0, y0, x1, y1;
  ASSERT_EQ(std::sscanf(svg.c_str() + path, "d='M%lf %lfL%lf %lf'", &x0, &y0, &x1, &y1), 4);
  EXPECT_NEAR((x1 - x0) / 4, y0 - y1, 0.1) << "pixels are printed with one decimal";
}

TEST(Base64, GivesTheTestVectorsOfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

TEST(PageData, NotANumberBecomesNothing) {
  const auto json = to_json(one_line({0, 1}, {NAN, 0.123456789}));
  EXPECT_TRUE(json["lines"][0]["y"][0].is_null());
  EXPECT_EQ(json["lines"][0]["y"][1], 0.12346);
}

TEST(Page, TheBundleIsInTheProgram) {
  EXPECT_GT(page_script().size(), 100000u);
  EXPECT_THAT(std::string(page_style()), HasSubstr(".dygraph-legend"));
  EXPECT_THAT(std::string(page_script()), Not(HasSubstr("</script")))
      << "it would end the element that holds it";
}

}  // namespace
