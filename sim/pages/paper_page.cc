#include "sim/pages/paper_page.h"

#include <fmt/core.h>

#include "sim/files/number.h"
#include "sim/pages/figure.h"
#include "sim/pages/html.h"
#include "sim/pages/paper_figures.h"
#include "sim/pages/paper_rows.h"
#include "sim/pages/pictures.h"

namespace sim::pages {
namespace {

constexpr int kPictures = 4;
constexpr double kWidth = 720, kHeight = 320, kEqualHeight = 560;  // px of a figure

const char* mark(Agreement agreement) {
  constexpr const char* kClasses[] = {"soft", "good", "good", "bad"};
  return kClasses[static_cast<int>(agreement)];
}

std::string table(const std::vector<PaperRow>& rows) {
  std::string html =
      "<div class=\"scroll\"><table "
      "class=\"named-rows\"><thead><tr><th>experiment</th><th>paper</th><th>this "
      "bench</th><th></th></tr></thead><tbody>\n";
  for (const PaperRow& row : rows)
    html += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td class=\"{}\">{}</td></tr>\n",
                        escaped(row.what), escaped(row.paper), escaped(row.bench), mark(row.agreement),
                        agreement_text(row.agreement));
  return html + "</tbody></table></div>\n";
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
  int count[4] = {};
  for (const PaperRow& row : rows) ++count[static_cast<int>(row.agreement)];
  std::size_t seeds = 0;
  for (const auto& [name, of] : runs) seeds = std::max(seeds, of.size());
  const int comparable = count[1] + count[2] + count[3];
  return fmt::format(
      "<p>{}, {} each. Of {} that can be compared, {} {}, {} {} better than the paper's, <strong>{} "
      "{}</strong>.{}</p>\n",
      files::counted(runs.size(), "experiment"), files::counted(seeds, "seed"),
      files::counted(static_cast<std::size_t>(comparable), "row"), count[1],
      count[1] == 1 ? "agrees" : "agree", count[2], count[2] == 1 ? "is" : "are", count[3],
      count[3] == 1 ? "differs" : "differ",
      count[0] > 0
          ? fmt::format(" {} cannot be compared.", files::counted(static_cast<std::size_t>(count[0]), "row"))
          : "");
}

std::string head(const std::string& revision) {
  return html_head("The paper reproduced", "") +
         fmt::format(
             "<h1>The paper reproduced</h1>\n<p class=\"soft\">Stasse, Davison, Sellaouti, Yokoi: Real-time "
             "3D "
             "SLAM for Humanoid Robot considering Pattern Generator Information, IROS 2006. GaitSLAM, "
             "revision "
             "{}.</p>\n",
             escaped(revision));
}

constexpr const char* kHowToRead =
    "<p class=\"soft\">The paper's filter is the filter with the measurements of the paper, Davison's depth "
    "particles and raw patches, as in scenarios/*_paper.yaml. This bench's filter is the default one. The "
    "drift is "
    "the true minus the planned pose of the waist at the end, as mean and standard deviation (sd) over "
    "seeds. "
    "The paper "
    "gives magnitudes without signs, so magnitudes are compared: they agree within a factor of two, or where "
    "both "
    "are below 10 mm or 1°. All other results are the median over seeds, with minimum and maximum. A loop is "
    "closed "
    "when three landmarks of the first quarter of the circle are recognised in its last quarter. ATE is the "
    "root "
    "mean square position error after SE(3) alignment.</p>\n";

// Figures 3 (a, d) and 4: what the paper's filter looks for in its images.
std::string head_views(const PaperRuns& runs) {
  const auto found = runs.find("tangent_circle_paper");
  if (found == runs.end() || found->second.empty()) return "";
  std::string html;
  for (const Picture& picture : pictures(found->second.front(), kPictures))
    html += fmt::format("<figure>{}<span class=\"soft\">{} s</span></figure>\n", picture.svg, picture.t);
  if (html.empty()) return "";
  return "<h2>Figures 3 and 4: patches and search ellipses</h2>\n<p class=\"soft\">Experiment 1, the paper's "
         "filter. Ellipses are the search regions of landmarks (3 sigma), green with the matched 11 x 11 "
         "patch where the match was used, yellow otherwise.</p>\n<div class=\"strip\">\n" +
         html + "</div>\n";
}

}  // namespace

std::string paper_page(const PaperRuns& runs, const std::string& revision) {
  const std::vector<PaperRow> rows = paper_rows(runs);
  std::string html = head(revision) + summary(runs, rows);
  html += "<h2>Paper and bench compared</h2>\n" + table(rows) + kHowToRead;
  html += "<h2>Where they differ</h2>\n" + differences(rows);
  html += "<h2>The figures of the paper reproduced</h2>\n<div class=\"figures\">\n";
  for (const Figure& figure : paper_figures(runs))
    html += fmt::format("<figure><figcaption>{}</figcaption>{}</figure>\n", escaped(figure.title),
                        to_svg(figure, kWidth, figure.equal_axes ? kEqualHeight : kHeight));
  html += "</div>\n" + head_views(runs);
  return html + kHtmlEnd;
}

}  // namespace sim::pages
