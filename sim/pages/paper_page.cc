#include <fmt/core.h>

#include <array>

#include "sim/files/text.h"
#include "sim/pages/html.h"
#include "sim/pages/paper.h"
#include "sim/pages/run_sections.h"

namespace sim::pages {
namespace {

constexpr int kHeadViews = 4;

std::string table(const std::vector<PaperRow>& rows) {
  constexpr std::array kClasses{"soft", "good", "good", "bad"};
  std::vector<TableRow> cells;
  for (const PaperRow& row : rows)
    cells.push_back(
        {{text_cell(row.what), text_cell(row.paper), text_cell(row.bench),
          text_cell(agreement_text(row.agreement), kClasses[static_cast<std::size_t>(row.agreement)])}});
  return table_html("paper and bench", {{"experiment"}, {"paper"}, {"this bench"}, {""}}, cells);
}

std::string differences(const std::vector<PaperRow>& rows) {
  std::string items;
  for (const PaperRow& row : rows)
    if (row.agreement == Agreement::differs)
      items += fmt::format("<li>{}. Paper: {}. Here: {}.</li>\n", escaped(row.what), escaped(row.paper),
                           escaped(row.bench));
  return items.empty() ? "<p>No row differs.</p>\n" : "<ul>\n" + items + "</ul>\n";
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

std::string paper_page(const PaperRuns& runs, const std::string& revision) {
  const std::vector<PaperRow> rows = paper_rows(runs);
  std::string figures;
  for (const Figure& figure : paper_figures(runs)) figures += figure_html(figure);
  return html_page(
      "The paper reproduced",
      "Stasse, Davison, Sellaouti, Yokoi: Real-time 3D SLAM for Humanoid Robot considering Pattern "
      "Generator Information, IROS 2006. GaitSLAM, revision " +
          escaped(revision),
      summary(runs, rows) + section_html("rows", "Paper and bench", table(rows) + kHowToRead) +
          section_html("differences", "Differences", differences(rows)) +
          section_html("figures", "The figures of the paper reproduced", figures_html(figures)) +
          head_views(runs));
}

}  // namespace sim::pages
