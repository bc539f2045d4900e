#include "sim/pages/pages.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::pages {
namespace {

using testing::DoubleNear, testing::ElementsAre, tests::Has, tests::Lacks;

Figure one_line(std::vector<double> x, std::vector<double> y) {
  Figure figure{"name", "Title", "x [m]", "y [m]"};
  figure.lines.push_back({"truth", Role::truth, std::move(x), std::move(y)});
  return figure;
}

TEST(Axis, TicksAreMultiplesOfOneTwoOrFiveInsideTheRange) {
  const auto near = [](double v) { return DoubleNear(v, 1e-9); };
  EXPECT_THAT((Axis{0.13, 0.98}.ticks(5)), ElementsAre(near(0.2), near(0.4), near(0.6), near(0.8)));
  EXPECT_THAT((Axis{-7, 7}.ticks(4)), ElementsAre(near(-5), near(0), near(5)));
  EXPECT_THAT((Axis{0.9, 3.1, 0, 1, false, true}.ticks(8)), ElementsAre(1, 2, 3)) << "counts are whole";
  const Axis decades{0.02, 150, 0, 1, true};
  EXPECT_THAT(decades.ticks(5), ElementsAre(near(0.1), near(1), near(10), near(100)));
  EXPECT_NEAR(decades.at(0.02), 0, 1e-12);
  EXPECT_NEAR(decades.at(150), 1, 1e-12);
  EXPECT_GE((Axis{2.1, 4.9, 0, 1, true}.ticks(5).size()), 2u) << "without a power of ten in it";
}

TEST(Axis, CoversAllFiniteValuesAndHandlesNone) {
  const std::vector<double> values{2, NAN, 5, INFINITY}, none{NAN};
  const Axis axis = axis_of({&values}, false);
  EXPECT_LT(axis.low, 2);
  EXPECT_GT(axis.high, 5);
  EXPECT_LT(axis.high, 6);
  EXPECT_LT(axis_of({&none}, false).low, axis_of({&none}, false).high);
}

RunData run_of(const Column& nees_position, const Column& nees_orientation, std::uint64_t seed = 1) {
  RunData run;
  run.seed = seed;
  run.errors.emplace();
  run.errors->t = {1, 6, 7, 8};
  run.errors->distance = {0, 0, 0, 0};
  run.errors->nees_position = nees_position;
  run.errors->nees_orientation = nees_orientation;
  return run;
}

Figure figure_named(const std::string& name, const std::vector<RunData>& runs) {
  const auto scenarios = comparison_figures(runs);
  for (const Figure& figure : scenarios.at(0).second)
    if (figure.name == name) return figure;
  throw std::runtime_error("no figure " + name);
}

// Two runs: the mean is in its band from 0.62 to 7.22; the first second does not count.
TEST(ComparisonFigures, GiveTheShareOfFramesWithTheMeanNeesInItsBand) {
  const Figure nees = figure_named(
      "nees_over_seeds_", {run_of({9, 3, 0.1, 9}, {1, 1, 1, 1}), run_of({9, 3, 0.2, 9}, {1, 1, 1, NAN}, 2)});
  EXPECT_THAT(nees.title, Has("position 33 % (below it 33 %), orientation 100 % (below it 0 %)"));
  EXPECT_THAT(nees.lines.at(0).y, ElementsAre(9, 3, DoubleNear(0.15, 1e-12), 9));
  EXPECT_NEAR(nees.levels.at(0).at, 0.62, 0.005);
  EXPECT_NEAR(nees.levels.at(1).at, 7.22, 0.005);
}

TEST(ComparisonFigures, SeveralSeedsOfASettingAreDotsWithABox) {
  std::vector<RunData> runs;
  for (const char* estimator : {"filter", "plan"})
    for (const std::uint64_t seed : {1, 2, 3}) {
      RunData& run = runs.emplace_back(run_of({1, 1, 1, 1}, {1, 1, 1, 1}));
      run.scenario = "hall", run.estimator = estimator, run.seed = seed;
      run.metrics = {{"ate_se3_rmse_m", "m", 0.001 * static_cast<double>(seed)}};
    }
  const Figure ate = figure_named("ate_by_setting_hall", runs);
  ASSERT_EQ(ate.lines.size(), 4u);
  EXPECT_EQ(ate.lines[2].name, "2: plan");
  EXPECT_THAT(ate.lines[2].x, ElementsAre(2, 2, 2));
  EXPECT_THAT(ate.lines[2].y, ElementsAre(DoubleNear(1, 1e-9), DoubleNear(2, 1e-9), DoubleNear(3, 1e-9)));
  const Line& box = ate.lines[3];
  EXPECT_EQ(box.name, "") << "the legend has its dots";
  EXPECT_NEAR(box.y.front(), 1, 1e-9);
  EXPECT_NEAR(box.y[2], 1.5, 1e-9) << "the lower quartile";
  EXPECT_NEAR(box.y.back(), 2, 1e-9) << "the median";
}

TEST(ComparisonFigures, RunsOfOneSeedWithDifferentSettingsAreSeparateLinesWithoutABand) {
  std::vector<RunData> runs(2, run_of({1, 1, 1, 1}, {1, 1, 1, 1}));
  runs[0].settings = {{"slam.a", "1"}, {"slam.b", "1"}},
  runs[1].settings = {{"slam.a", "1"}, {"slam.b", "2"}};
  const Figure apart = figure_named("error_over_time_", runs);
  EXPECT_THAT(apart.title, Lacks("median"));
  ASSERT_EQ(apart.lines.size(), 2u);
  EXPECT_EQ(apart.lines[0].name, "slam.b=1");
  EXPECT_EQ(apart.lines[1].name, "slam.b=2");
  EXPECT_THROW(figure_named("nees_over_seeds_", runs), std::runtime_error);
  runs[1].settings = runs[0].settings;
  EXPECT_THROW(figure_named("nees_over_seeds_", runs), std::runtime_error) << "one seed twice";
}

TEST(Figures, CompareTheEstimateWithAThinLineWithoutImages) {
  RunData run = run_of({1, 1, 1, 1}, {1, 1, 1, 1});
  run.odometry = {{1, 6, 7, 8}, {0, 1, 2, 3}, {0, 0, 0, 0}, {0, 0, 0, 0}};
  run.truth = *run.odometry;
  run.odometry_error = {0, 0.01, 0.02, 0.04};
  RunData other = run;
  other.seed = 2, other.odometry_error = {0, 0.03, 0.04, 0.08};
  const auto in_mm = [](double a, double b, double c) {
    return ElementsAre(0, DoubleNear(a, 1e-9), DoubleNear(b, 1e-9), DoubleNear(c, 1e-9));
  };
  for (const Figure& figure : run_figures(run)) {
    if (figure.name == "from_above") {
      EXPECT_EQ(figure.lines.at(0).name, "truth") << "the run has no plan";
      EXPECT_TRUE(figure.lines.at(1).thin);
    }
    if (figure.name != "error_distance") continue;
    EXPECT_THAT(figure.lines.at(1).y, in_mm(10, 20, 40));
    EXPECT_THAT(to_svg(figure, 400, 300), Has("class='line thin third' data-name='odometry, no images'"));
  }
  EXPECT_THAT(figure_named("error_over_time_", {run, other}).lines.back().y, in_mm(20, 30, 60));
  other.estimator = "odometry";
  for (const char* const figure : {"error_over_time_", "paths_"})
    for (const Line& line : figure_named(figure, {run, other}).lines)
      EXPECT_FALSE(line.thin) << "it has its own line";
}

TEST(RunFigures, NisHasItsBand) {
  const sim::files::TemporaryFolder folder;
  std::ofstream(folder / "frames.csv")
      << "#timestamp [ns],landmarks,measured,accepted,nis_gyro,dof_gyro\n0,0,0,0,0.06,3\n1,0,0,0,0.06,3\n";
  RunData run = run_of({1, 1, 1, 1}, {1, 1, 1, 1});
  run.filter_frames.emplace(folder / "frames.csv");
  const std::vector<Figure> figures = run_figures(run);
  const auto nis = std::ranges::find(figures, std::string("nis"), &Figure::name);
  ASSERT_NE(nis, figures.end());
  EXPECT_THAT(nis->envelopes.at(0).low, testing::Each(DoubleNear(0.73, 0.01)));  // chi-square of 93, 2.5 %
  EXPECT_THAT(nis->envelopes.at(0).high, testing::Each(DoubleNear(1.31, 0.01)));
}

TEST(Svg, NotANumberBreaksALine) {
  const auto strokes = [](const Figure& figure) {
    const std::string svg = to_svg(figure, 400, 300);
    const std::size_t line = svg.find(" d='", svg.find("class='line"));
    const std::string path = svg.substr(line, svg.find("/>", line) - line);
    return std::ranges::count(path, 'M');
  };
  EXPECT_EQ(strokes(one_line({0, 1, 2, 3}, {0, 1, 2, 3})), 1);
  EXPECT_EQ(strokes(one_line({0, 1, 2, 3}, {0, NAN, 2, 3})), 2);
}

TEST(Svg, AStillPictureHasItsColorsAWrappedTitleAndALegend) {
  Figure figure = one_line({0, 1}, {0, 1});
  figure.title = "A title that is as long as those of some of the figures of a report";
  const std::string svg = to_svg(figure, 300, 300);
  EXPECT_THAT(
      svg, Has("y='18.0' class='title'>A title that is as long as those of</text>",
               "y='36.0' class='title'>some of the figures of a report</text>", "y='54.0' >truth</text>",
               "<rect class='frame' x='72.0' y='66.0'", "{stroke:#0072b2;stroke:var(--estimate,#0072b2)}"));
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

// web/figures.js reads values under the cursor from the axes and the named paths.
TEST(PageSvg, HasItsAxesAndTheNamesOfItsLines) {
  Figure figure = one_line({0, 10}, {1, 100});
  figure.x_label = "time [s]", figure.logarithmic = true;
  const std::string svg = to_svg(figure, 400, 300, Surroundings::page);
  EXPECT_THAT(svg, AllOf(Has("data-name='truth'"), Lacks("<style"),
                         testing::ContainsRegex("data-x='-0.5 10.5 72 386 0' data-y='0.6[0-9]* 150 254 12 1' "
                                                "data-over-time='yes'")));
}

TEST(FrameError, IsEstimateMinusTruth) {
  Frame frame;
  EXPECT_FALSE(error_of(frame).has_value());
  frame.truth = frame.estimate = Eigen::Isometry3d::Identity();
  frame.estimate->translation() = Eigen::Vector3d(0.01, -0.02, 0.03);
  frame.estimate->rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(std::isnan(error_of(frame)->nees.position)) << "without a covariance";
  frame.covariance = files::Matrix6d::Identity() * 1e-4;
  const auto error = error_of(frame);
  EXPECT_TRUE(error->error.isApprox(Eigen::Vector4d(0.01, -0.02, 0.03, 0.1), 1e-12));
  EXPECT_TRUE(error->sigma.isApprox(Eigen::Vector4d::Constant(0.01), 1e-9));
  EXPECT_NEAR(error->nees.position, 14, 1e-9) << "(1 + 4 + 9) sigmas squared";
}

}  // namespace
}  // namespace sim::pages
