#include <fmt/core.h>

#include "sim/report/page.h"
#include "sim/report/paper.h"
#include "sim/report/pictures.h"

namespace sim::report {
namespace {

constexpr int kPictures = 4;
constexpr double kWidth = 720, kHeight = 320, kEqualHeight = 560;  // px of a figure

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

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
  return items.empty() ? "<p>Nowhere.</p>\n" : "<ul>\n" + items + "</ul>\n";
}

std::string summary(const PaperRuns& runs, const std::vector<PaperRow>& rows) {
  int count[4] = {};
  for (const PaperRow& row : rows) ++count[static_cast<int>(row.agreement)];
  std::size_t seeds = 0;
  for (const auto& [name, of] : runs) seeds = std::max(seeds, of.size());
  return fmt::format(
      "<p>{} experiments, {} seeds each. Of {} rows, {} agree, {} {} better than the paper's, <strong>{} "
      "differ</strong>{}.</p>\n",
      runs.size(), seeds, rows.size(), count[1], count[2], count[2] == 1 ? "is" : "are", count[3],
      count[0] > 0 ? fmt::format(", {} could not be judged", count[0]) : "");
}

std::string head(const std::string& revision) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>GaitSLAM: the paper "
      "reproduced</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n{}</style>\n</head>\n<body>\n"
      "<h1>The paper reproduced</h1>\n<p class=\"soft\">Stasse, Davison, Sellaouti, Yokoi: Real-time 3D SLAM "
      "for Humanoid Robot considering Pattern Generator Information, IROS 2006. GaitSLAM, revision {}.</p>\n",
      page_style(), escaped(revision));
}

constexpr const char* kHowToRead =
    "<p class=\"soft\">The paper's filter: the filter with the paper's measurements, Davison's lines with "
    "depth "
    "particles and raw patches, as in scenarios/*_paper.yaml. This bench's filter: the default. Drift: true "
    "minus planned waist at the end, mean and standard deviation over seeds; the paper gives sizes without "
    "signs, so sizes are compared, and agree within a factor of two or where both are below 10 mm or 1°. All "
    "else: median over seeds, least and greatest. A loop is closed when three landmarks of the circle's "
    "first "
    "quarter are found again in its last. ATE: root mean square position error after SE(3) alignment.</p>\n";

// Figures 3 (a, d) and 4: what the paper's filter looks for in its images.
std::string head_views(const PaperRuns& runs) {
  const auto found = runs.find("tangent_circle_paper");
  if (found == runs.end() || found->second.empty()) return "";
  std::string html;
  for (const Picture& picture : pictures(found->second.front(), kPictures))
    html += fmt::format("<figure>{}<span class=\"soft\">{} s</span></figure>\n", picture.svg, picture.t);
  if (html.empty()) return "";
  return "<h2>Figures 3 and 4: patches and search ellipses</h2>\n<p class=\"soft\">Experiment 1, the paper's "
         "filter. Ellipses: where landmarks were looked for (3 sigma); green with their 11 x 11 patches "
         "where the "
         "match was used, yellow where not.</p>\n<div class=\"strip\">\n" +
         html + "</div>\n";
}

}  // namespace

std::string paper_page(const PaperRuns& runs, const std::string& revision) {
  const std::vector<PaperRow> rows = paper_rows(runs);
  std::string html = head(revision) + summary(runs, rows);
  html += "<h2>Paper and bench side by side</h2>\n" + table(rows) + kHowToRead;
  html += "<h2>Where they differ</h2>\n" + differences(rows);
  html += "<h2>The paper's figures remade</h2>\n<div class=\"figures\">\n";
  for (const Figure& figure : paper_figures(runs))
    html += fmt::format("<figure><figcaption>{}</figcaption>{}</figure>\n", escaped(figure.title),
                        to_svg(figure, kWidth, figure.equal_axes ? kEqualHeight : kHeight));
  html += "</div>\n" + head_views(runs);
  return html + "</body>\n</html>\n";
}

}  // namespace sim::report
