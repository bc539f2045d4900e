#include <fmt/core.h>

#include "sim/report/page.h"
#include "sim/report/paper.h"

namespace sim::report {
namespace {

constexpr double kWidth = 720, kHeight = 320, kEqualHeight = 560;

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

std::string table(const std::vector<PaperRow>& rows) {
  std::string html =
      "<div class=\"scroll\"><table><thead><tr><th>experiment</th><th>paper</th><th>this "
      "bench</th><th></th></tr>"
      "</thead><tbody>\n";
  for (const PaperRow& row : rows) {
    const char* mark = row.verdict == "differs" ? "bad" : "good";
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"{}\">{}</td></tr>\n",
                        escaped(row.what), escaped(row.paper), escaped(row.bench), mark, row.verdict);
  }
  return html + "</tbody></table></div>\n";
}

std::string differences(const std::vector<PaperRow>& rows) {
  std::string items;
  for (const PaperRow& row : rows)
    if (row.verdict == "differs")
      items += fmt::format("<li>{}: paper {}; here {}.</li>\n", escaped(row.what), escaped(row.paper),
                           escaped(row.bench));
  return items.empty() ? "<p>Nowhere.</p>\n" : "<ul>\n" + items + "</ul>\n";
}

std::string head(const std::string& revision) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>GaitSLAM: the paper "
      "reproduced</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n{}</style>\n</head>\n<body>\n"
      "<h1>The paper reproduced</h1>\n<p class=\"soft\">Stasse, Davison, Sellaouti, Yokoi: Real-time 3D SLAM "
      "for "
      "Humanoid Robot considering Pattern Generator Information, IROS 2006. Revision {}.</p>\n",
      page_style(), escaped(revision));
}

}  // namespace

std::string paper_page(const PaperRuns& runs, const std::string& revision) {
  const std::vector<PaperRow> rows = paper_rows(runs);
  std::string html = head(revision);
  html += "<h2>Paper and bench side by side</h2>\n" + table(rows) +
          "<p class=\"soft\">Drifts: true minus planned waist at the end, mean (standard deviation) over "
          "seeds; the "
          "paper gives sizes without signs. They agree where every mean above 10 mm or 1° is within a factor "
          "of two.</p>\n";
  html += "<h2>Where they differ</h2>\n" + differences(rows);
  html += "<h2>The paper's figures remade</h2>\n<div class=\"figures\">\n";
  for (const Figure& figure : paper_figures(runs))
    html += fmt::format("<figure><figcaption>{}</figcaption>{}</figure>\n", escaped(figure.title),
                        to_svg(figure, kWidth, figure.equal_axes ? kEqualHeight : kHeight));
  return html + "</div>\n</body>\n</html>\n";
}

}  // namespace sim::report
