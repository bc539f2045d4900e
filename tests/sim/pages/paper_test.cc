#include "sim/pages/paper.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

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
  for (const auto& [x, yaw, agreement] :
       {std::tuple{-0.009, 0.9, Agreement::agrees}, {-0.012, 1.1, Agreement::differs}}) {
    const auto rows =
        paper_rows({{"tangent_quadrant", {run(1, {{"plan_drift_x_m", x}, {"plan_drift_yaw_deg", yaw}})}}});
    EXPECT_EQ(row(rows, "Tangent quadrant: drift in X").agreement, agreement);
    EXPECT_EQ(row(rows, "Tangent quadrant: drift in yaw").agreement, agreement);
  }
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

/// Figure 3 of the depths.csv with these rows.
Figure depths(const std::string& rows) {
  const sim::files::TemporaryFolder folder;
  sim::files::write_text(folder / "depths.csv", "#timestamp [ns],landmark,depth [m],probability\n" + rows);
  return depths_figure(folder / "depths.csv");
}

TEST(Depths, TheFigureIsOfTheLandmarkThatTookMostImagesToBecomeKnown) {
  const Figure f = depths(
      "0,1,2,0.5\n0,1,8,0.5\n"                  // 1: never known
      "0,2,3,0.5\n0,2,5,0.5\n33000000,2,4,1\n"  // 2: after two images
      "0,3,1,0.5\n0,3,9,0.5\n1,3,5,0.5\n1,3,9,0.5\n2,3,6,0.9\n2,3,7,0.1\n3,3,6,1\n");
  ASSERT_THAT(f.lines, SizeIs(4));
  EXPECT_EQ(f.lines[0].name, "after 1 image");
  EXPECT_THAT(f.lines[0].x, testing::ElementsAre(1, 9));
  EXPECT_EQ(f.lines[3].name, "after 4 images");
  EXPECT_THAT(f.lines[3].y, testing::ElementsAre(1));
  EXPECT_THAT(depths("0,1,2,0.5\n0,1,8,0.5\n").lines, IsEmpty()) << "no depth became known";
}

}  // namespace
