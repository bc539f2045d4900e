#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "sim/files/text.h"
#include "sim/pages/html.h"
#include "sim/pages/pages.h"
#include "sim/pages/paper.h"

namespace sim::pages {
namespace {

constexpr int kHeadViews = 4;

Figure depths(const RunData& run) {
  const auto file = run.folder / "depths.csv";
  return std::filesystem::exists(file) ? depths_figure(file) : Figure{};
}

/// A figure of the paper, drawn from the first run of an experiment, or from the first that closed its loop.
struct PaperFigure {
  const char *name, *title, *experiment;
  Figure (*draw)(const RunData& run);
  bool closed = false;
};

constexpr PaperFigure kFigures[]{
    {"figure_1", "Figure 1: waist, planned and walked, a tangent quadrant", "tangent_quadrant",
     waist_from_above},
    {"figure_1_circle", "Figure 1: waist, planned and walked, facing the center, first trial",
     "perpendicular_circle_trial1", waist_from_above},
    {"figure_3", "Figure 3: depth hypotheses of a new landmark collapse to a peak", "tangent_circle_paper",
     depths, true},
    {"figure_4", "Figure 4: uncertainty of the position until the loop closes; vision and gyro",
     "vision_gyro_known_landmarks", [](const RunData& run) { return uncertainty(run); }, true},
    {"figure_6_paper", "Figure 6: plan and SLAM, experiment 1, the paper's filter", "tangent_circle_paper",
     camera_from_above, true},
    {"figure_6", "Figure 6: the same walk, this bench's filter", "tangent_circle", camera_from_above},
    {"figure_7_paper", "Figure 7: plan and SLAM, experiment 2, the paper's filter",
     "perpendicular_circle_paper", camera_from_above, true},
    {"figure_7", "Figure 7: experiment 2, this bench's filter", "perpendicular_circle", camera_from_above},
    {"figure_8", "Figure 8: height of the camera in experiment 1, the paper's filter", "tangent_circle_paper",
     camera_height, true}};

const RunData* run_of(const PaperFigure& figure, const PaperRuns& all) {
  const std::vector<RunData>& runs = runs_of(all, figure.experiment);
  for (const RunData& run : runs)
    if (!figure.closed || run.metric("loop_time_s")) return &run;
  return runs.empty() ? nullptr : &runs.front();
}

constexpr double kKnown = 0.3;  // standard deviation by mean: Davison 2003

struct Hypotheses {
  Column depth, probability;
};
using History = std::map<double, Hypotheses>;  // of a landmark, by time

double relative_sigma(const Hypotheses& h) {
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < h.depth.size(); ++i) {
    mean += h.probability[i] * h.depth[i];
    square += h.probability[i] * h.depth[i] * h.depth[i];
  }
  return std::sqrt(std::max(0.0, square - mean * mean)) / mean;
}

/// Figures 1, 3, 4, 6, 7 and 8 of the paper, each from the first seed that shows it.
std::string figures(const PaperRuns& all) {
  std::string html;
  for (const PaperFigure& figure : kFigures) {
    const RunData* const run = run_of(figure, all);
    Figure drawn = run ? figure.draw(*run) : Figure{};
    if (drawn.lines.empty()) continue;
    drawn.name = figure.name;
    drawn.title = fmt::format("{} (seed {})", figure.title, run->seed);
    html += figure_html(drawn);
  }
  return figures_html(html);
}

std::string table(const std::vector<PaperRow>& rows) {
  constexpr std::array kClasses{"soft", "good", "good", "bad"};
  std::vector<TableRow> cells;
  for (const PaperRow& row : rows)
    cells.push_back(
        {{text_cell(row.what), text_cell(row.paper), text_cell(row.bench),
          text_cell(agreement_text(row.agreement), kClasses[static_cast<std::size_t>(row.agreement)])}});
  return table_html("paper and bench", {{"experiment"}, {"paper"}, {"this bench"}, {""}}, cells);
}

std::string summary(const PaperRuns& runs, const std::vector<PaperRow>& rows) {
  std::array<std::size_t, 4> count{};
  for (const PaperRow& row : rows) ++count[static_cast<std::size_t>(row.agreement)];
  std::size_t seeds = 0;
  for (const auto& [name, of] : runs) seeds = std::max(seeds, of.size());
  return fmt::format(
      "<p>{}, {} each. Comparable rows: {}; agree: {}; better than the paper: {}; "
      "<strong>differ: {}</strong>. Not comparable: {}.</p>\n",
      files::counted(runs.size(), "experiment"), files::counted(seeds, "seed"),
      count[1] + count[2] + count[3], count[1], count[2], count[3], count[0]);
}

constexpr const char* kHowToRead =
    "<p class='soft'>The paper's filter has the measurements of the paper, Davison's depth particles and raw "
    "patches (scenarios/*_paper.yaml). This bench's filter is the default one. Drift is the true minus the "
    "planned pose of the waist at the end, as mean and standard deviation (sd) over seeds. The paper gives "
    "magnitudes without signs: they agree within a factor of two, or if both are below 10 mm or 1°. Other "
    "results are the median over seeds with minimum and maximum. A loop is closed when three landmarks of "
    "the "
    "first quarter of the circle are recognized in its last quarter. ATE is the root mean square position "
    "error after SE(3) alignment.</p>\n";

// Figures 3 (a, d) and 4: what the paper's filter searches for in its images.
std::string head_views(const PaperRuns& runs) {
  const std::vector<RunData>& shown = runs_of(runs, "tangent_circle_paper");
  std::string html;
  if (!shown.empty())
    for (const Picture& picture : pictures(shown.front(), kHeadViews))
      html += fmt::format("<figure>{}<span class='soft'>{} s</span></figure>\n", picture.svg, picture.t);
  if (html.empty()) return "";
  return section_html(
      "images", "Figures 3 and 4: patches and search ellipses",
      "<p class='soft'>Experiment 1, the paper's filter. Ellipses are the search regions of "
      "landmarks (3 sigma): green with the matched 11 x 11 patch if the match was used, yellow "
      "otherwise.</p>\n<div class='strip'>\n" +
          html + "</div>\n");
}

}  // namespace

Figure depths_figure(const std::filesystem::path& depths_csv) {
  Figure f{"", "", "depth [m]", "probability of a hypothesis"};
  const Table table(depths_csv);
  const Column t = table.seconds("timestamp"), id = table.numbers("landmark"), depth = table.numbers("depth"),
               probability = table.numbers("probability");
  std::map<double, History> all;  // by landmark
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Hypotheses& at = all[id[i]][t[i]];
    at.depth.push_back(depth[i]), at.probability.push_back(probability[i]);
  }
  const History* longest = nullptr;
  for (const auto& [landmark, history] : all)
    if (relative_sigma(history.rbegin()->second) < kKnown && (!longest || history.size() > longest->size()))
      longest = &history;
  if (!longest) return f;
  constexpr Role kRoles[] = {Role::third, Role::second, Role::first, Role::estimate};
  const std::size_t last = longest->size() - 1;
  for (std::size_t k = 0; k < std::size(kRoles); ++k) {
    const std::size_t image = k * last / (std::size(kRoles) - 1);
    const Hypotheses& h = std::next(longest->begin(), static_cast<std::ptrdiff_t>(image))->second;
    f.lines.push_back({fmt::format("after {} image{}", image + 1, image == 0 ? "" : "s"), kRoles[k], h.depth,
                       h.probability});
  }
  return f;
}

std::string paper_page(const PaperRuns& runs, const std::string& revision) {
  const std::vector<PaperRow> rows = paper_rows(runs);
  return html_page(
      "The paper reproduced",
      "Stasse, Davison, Sellaouti, Yokoi: Real-time 3D SLAM for Humanoid Robot considering Pattern "
      "Generator Information, IROS 2006. GaitSLAM, revision " +
          escaped(revision),
      summary(runs, rows) + section_html("rows", "Paper and bench", table(rows) + kHowToRead) +
          section_html("figures", "The figures of the paper reproduced", figures(runs)) + head_views(runs));
}

}  // namespace sim::pages
