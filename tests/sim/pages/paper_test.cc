#include "sim/pages/paper.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

namespace {

using namespace sim::pages;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

RunData run(std::uint64_t seed, const std::map<std::string, double>& metrics) {
  RunData data;
  data.seed = seed;
  data.ending = "completed";
  for (const auto& [name, value] : metrics) data.metrics.push_back({name, "", "", value});
  return data;
}

const PaperRow& row(const std::vector<PaperRow>& rows, const std::string& what) {
  const auto found =
      std::find_if(rows.begin(), rows.end(), [&](const PaperRow& r) { return r.what.starts_with(what); });
  if (found == rows.end()) throw std::runtime_error("no row " + what);
  return *found;
}

TEST(PaperRows, AnExperimentThatWasNotRunSaysSoAndIsNotJudged) {
  for (const PaperRow& r : paper_rows({})) {
    EXPECT_EQ(r.bench, "not run") << r.what;
    EXPECT_EQ(r.agreement, Agreement::none) << r.what;
  }
}

TEST(PaperRows, DriftsAgreeWithinAFactorOfTwoWhateverTheirSigns) {
  PaperRuns runs;
  runs["perpendicular_circle_trial1"] = {
      run(1, {{"plan_drift_x_m", 0.09}, {"plan_drift_y_m", -0.34}, {"plan_drift_yaw_deg", 29}}),
      run(2, {{"plan_drift_x_m", 0.11}, {"plan_drift_y_m", -0.36}, {"plan_drift_yaw_deg", 31}})};
  const auto rows = paper_rows(runs);
  const auto& x = row(rows, "Facing the center, first trial: drift in X");
  EXPECT_EQ(x.paper, "240 mm");
  EXPECT_EQ(x.bench, "100.0 mm (sd 14.1)") << "the sample deviation of 90 and 110";
  EXPECT_EQ(x.agreement, Agreement::differs) << "100 is below 240 / 2";
  EXPECT_EQ(row(rows, "Facing the center, first trial: drift in Y").agreement, Agreement::agrees);
  EXPECT_EQ(row(rows, "Facing the center, first trial: drift in yaw").agreement, Agreement::agrees);
}

TEST(PaperRows, DriftsBelowTheNegligibleAgree) {
  PaperRuns runs;
  runs["tangent_quadrant"] = {run(1, {{"plan_drift_x_m", -0.009}, {"plan_drift_yaw_deg", 0.9}})};
  EXPECT_EQ(row(paper_rows(runs), "Tangent quadrant: drift in X").agreement, Agreement::agrees);
  EXPECT_EQ(row(paper_rows(runs), "Tangent quadrant: drift in yaw").agreement, Agreement::agrees);
  runs["tangent_quadrant"] = {run(1, {{"plan_drift_x_m", -0.012}, {"plan_drift_yaw_deg", 1.1}})};
  EXPECT_EQ(row(paper_rows(runs), "Tangent quadrant: drift in X").agreement, Agreement::differs);
  EXPECT_EQ(row(paper_rows(runs), "Tangent quadrant: drift in yaw").agreement, Agreement::differs);
}

TEST(PaperRows, ClosingWhereThePaperFailedDiffersForItsFilterAndIsBetterForOurs) {
  PaperRuns runs;
  runs["hall_paper"] = runs["hall"] =
      runs["tangent_circle"] = {run(1, {{"loop_closed", 1}, {"loop_landmarks", 12}})};
  EXPECT_EQ(row(paper_rows(runs), "The hall, the paper's filter").agreement, Agreement::differs);
  EXPECT_EQ(row(paper_rows(runs), "The hall, this bench's filter").agreement, Agreement::better);
  EXPECT_EQ(row(paper_rows(runs), "Experiment 1, this bench's filter").agreement, Agreement::agrees);
  runs["hall_paper"].push_back(run(2, {{"loop_closed", 0}}));
  EXPECT_THAT(row(paper_rows(runs), "The hall, the paper's filter").bench, HasSubstr("1 of 2 closed"));
  runs["tangent_circle"].push_back(run(2, {{"loop_closed", 0}}));
  EXPECT_EQ(row(paper_rows(runs), "Experiment 1, this bench's filter").agreement, Agreement::differs);
}

TEST(PaperRows, OneRunHasNoStandardDeviationAndNoRange) {
  PaperRuns runs;
  runs["tangent_quadrant"] = {run(1, {{"plan_drift_x_m", -0.009}})};
  runs["tangent_circle"] = {run(1, {{"loop_closed", 1}, {"loop_landmarks", 12}})};
  EXPECT_EQ(row(paper_rows(runs), "Tangent quadrant: drift in X").bench, "-9.0 mm");
  EXPECT_EQ(row(paper_rows(runs), "Experiment 1, this bench's filter").bench,
            "1 of 1 closed; landmarks recognized: 12; ATE none");
}

TEST(PaperRows, TimesOnOtherComputersAreNotCompared) {
  PaperRuns runs;
  runs["tangent_circle"] = {run(1, {})};
  runs["tangent_circle"][0].frame_cpu_ms_median = 0.5;
  const PaperRow time = row(paper_rows(runs), "CPU time of a frame, this bench's filter");
  EXPECT_EQ(time.bench, "0.5 ms, on another computer: not comparable");
  EXPECT_EQ(time.agreement, Agreement::none);
}

TEST(PaperPage, CountsRowsByTheirAgreement) {
  PaperRuns runs;
  runs["tangent_quadrant"] = {run(1, {{"plan_drift_x_m", -0.009}})};
  EXPECT_THAT(
      paper_page(runs, "abc"),
      HasSubstr("<p>1 experiment, 1 seed each. Comparable rows: 1; agree: 1; better than the paper: 0; "
                "<strong>differ: 0</strong>. Not comparable: " +
                std::to_string(paper_rows(runs).size() - 1) + ".</p>"));
}

TEST(PaperPage, SaysWhereItDiffers) {
  PaperRuns runs;
  runs["hall_paper"] = {run(1, {{"loop_closed", 1}})};
  const std::string page = paper_page(runs, "abc");
  const std::string differ = page.substr(page.find("<h2>Differences</h2>"));
  EXPECT_THAT(differ, HasSubstr("<li>The hall, the paper&#39;s filter (V). Paper: fails"));
  EXPECT_THAT(paper_page({}, "abc"), HasSubstr("No row differs"));
}

// Steps of 0.8 s: the height changes by `jump` in the frame after an impact and by noise elsewhere.
struct Heights {
  Column t, z, impacts;
};
Heights heights(double jump, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Heights h;
  double z = 1;
  for (int i = 0; i < 30 * 40; ++i) {
    const double t = i / 30.0;
    if (i % 24 == 6) h.impacts.push_back(t - 0.01);
    z += 1e-4 * (static_cast<double>(random() % 2001) - 1000) / 1000 + (i % 24 == 6 ? jump : 0);
    h.t.push_back(t), h.z.push_back(z);
  }
  return h;
}

TEST(ImpactLink, FindsJumpsThatFollowImpacts) {
  const Heights h = heights(0.001, 1);
  const auto link = impact_link(h.t, h.z, h.impacts);
  ASSERT_TRUE(link);
  EXPECT_LT(link->p, 1e-6) << "in all of 50 steps";
  // One of three frames after an impact changes by 1 mm, all others by 0.05 mm in the mean: (1 + 2 x 0.05) /
  // 3 / 0.05.
  EXPECT_NEAR(link->ratio, 7.3, 0.7);
}

TEST(ImpactLink, FindsNoneInNoiseMoreOftenThanItsLevel) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Heights h = heights(0, seed);
    found += impact_link(h.t, h.z, h.impacts)->p < 0.05;
  }
  EXPECT_GT(found, 1);
  EXPECT_LT(found, 21) << "10 of 200 are expected; 21 or more come in 0.1 % of all cases";
}

TEST(ImpactLink, IsNotAskedOfAShortWalk) {
  const Heights h = heights(0, 1);
  EXPECT_FALSE(impact_link(Column(99, 0.0), Column(99, 1.0), h.impacts));
  EXPECT_FALSE(impact_link(h.t, h.z, {1, 2}));
}

class Depths : public testing::Test {
 protected:
  std::filesystem::path file_ =
      testing::TempDir() + "gaitslam_depths_" + testing::UnitTest::GetInstance()->current_test_info()->name();
  ~Depths() override { std::filesystem::remove(file_); }
  Figure figure(const std::string& rows) {
    std::ofstream(file_) << "#timestamp [ns],landmark,depth [m],probability\n" << rows;
    return depths_figure(file_);
  }
};

TEST_F(Depths, TheFigureIsOfTheLandmarkThatTookMostImagesToBecomeKnown) {
  const Figure f = figure(
      "0,1,2,0.5\n0,1,8,0.5\n"                  // 1: never known
      "0,2,3,0.5\n0,2,5,0.5\n33000000,2,4,1\n"  // 2: after two images
      "0,3,1,0.5\n0,3,9,0.5\n1,3,5,0.5\n1,3,9,0.5\n2,3,6,0.9\n2,3,7,0.1\n3,3,6,1\n");
  ASSERT_THAT(f.lines, SizeIs(4));
  EXPECT_EQ(f.lines[0].name, "after 1 image");
  EXPECT_THAT(f.lines[0].x, testing::ElementsAre(1, 9));
  EXPECT_EQ(f.lines[3].name, "after 4 images");
  EXPECT_THAT(f.lines[3].y, testing::ElementsAre(1));
}

TEST_F(Depths, NothingIsDrawnWhereNoDepthBecameKnown) {
  EXPECT_THAT(figure("0,1,2,0.5\n0,1,8,0.5\n").lines, IsEmpty());
}

}  // namespace
