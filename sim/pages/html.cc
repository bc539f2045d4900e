#include "sim/pages/html.h"

#include <fmt/format.h>

#include <cmath>

#include "sim/files/hash.h"
#include "sim/files/text.h"

// The files that esbuild makes from web/.
GAITSLAM_EMBED(gaitslam_page_script, GAITSLAM_BUNDLE "/pages.js")
GAITSLAM_EMBED(gaitslam_map_script, GAITSLAM_BUNDLE "/map.js")
GAITSLAM_EMBED(gaitslam_page_style, GAITSLAM_BUNDLE "/pages.css")

namespace sim::pages {
namespace {

constexpr double kEqualHeight = 480;  // px of a figure

// Pictures are part of the page and figures have their own styles. Nothing else is loaded.
std::string content_security_policy(const std::vector<std::string_view>& scripts) {
  std::string allowed;
  for (const std::string_view script : scripts)
    allowed += fmt::format(" 'sha256-{}'", base64(files::sha256(script)));
  return fmt::format(
      "default-src 'none'; script-src{}; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
      "form-action 'none'",
      allowed.empty() ? " 'none'" : allowed);
}

std::string row_html(const TableRow& row, const char* tag) {
  std::string html = row.id.empty() ? "<tr>" : fmt::format("<tr id='{}'>", escaped(row.id));
  for (const TableCell& cell : row.cells)
    html += fmt::format("<{0}{1}>{2}</{0}>", tag,
                        cell.style.empty() ? "" : fmt::format(" class='{}'", cell.style), cell.html);
  return html + "</tr>\n";
}

std::string legend_html(const Figure& figure) {
  std::string items;
  const auto add = [&](const auto& named) {
    for (const auto& one : named)
      if (!one.name.empty())
        items += fmt::format("<span class='role-{}' data-name='{}'>{} <b></b></span> ", role_name(one.role),
                             escaped(one.name), escaped(one.name));
  };
  add(figure.lines), add(figure.envelopes);
  return items.empty() ? "" : "<p class='legend'><span class='at'></span> " + items + "</p>";
}

}  // namespace

std::string base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

// Without "<", neither "</script>" nor "<!--" can end the element or start a comment in it.
std::string data_script(std::string_view id, std::string_view json) {
  std::string text = fmt::format("<script type=\"application/json\" id=\"{}\">", escaped(id));
  for (const char c : json) text += c == '<' ? "\\u003c" : std::string(1, c);
  return text + "</script>\n";
}

TableCell text_cell(std::string_view text, const std::string& style) { return {escaped(text), style}; }
TableCell code_cell(std::string_view text) { return {"<code>" + escaped(text) + "</code>"}; }
TableCell number_cell(std::optional<double> value) { return {number_text(value), "number"}; }
std::string number_text(std::optional<double> value) {
  return value && std::isfinite(*value) ? fmt::format("{:.4g}", *value) : "-";
}

std::string table_html(std::string_view name, const std::vector<TableCell>& titles,
                       const std::vector<TableRow>& rows) {
  std::string html = fmt::format(
      "<div class='scroll' tabindex='0' role='region' aria-label='{}'><table class='named-rows'><thead>",
      escaped(name));
  html += row_html({titles}, "th") + "</thead><tbody>\n";
  for (const TableRow& row : rows) html += row_html(row, "td");
  return html + "</tbody></table></div>\n";
}

std::string figure_html(const Figure& figure, const std::string& below, double height, double width) {
  std::string remarks;
  for (const std::string& remark : figure.remarks)
    remarks += fmt::format("<p class='soft'>{}</p>", escaped(remark));
  return fmt::format("<figure data-figure='{}'><figcaption>{}</figcaption>{}{}{}{}</figure>\n",
                     escaped(figure.name), escaped(figure.title), remarks,
                     to_svg(figure, width, figure.equal_axes ? kEqualHeight : height, true),
                     legend_html(figure), below);
}

std::string figures_html(const std::string& figures) {
  return "<div class='figures'>" + figures + "</div>\n";
}

std::string sections_html(const std::vector<Section>& sections, bool with_links) {
  std::string links = "<nav aria-label='sections'>", html;
  int count = 0;
  for (const Section& section : sections) {
    if (section.html.empty()) continue;
    ++count;
    links += fmt::format("<a href='#{}'>{}</a> ", escaped(section.id), escaped(section.title));
    html += fmt::format("<section id='{}'><h2>{}</h2>\n{}</section>\n", escaped(section.id),
                        escaped(section.title), section.html);
  }
  return (with_links && count > 1 ? links + "</nav>\n" : "") + html;
}

std::string_view page_script() { return gaitslam_page_script(); }
std::string_view map_script() { return gaitslam_map_script(); }

std::string html_page(std::string_view title, const std::string& subtitle, const std::string& body,
                      const std::vector<std::string_view>& scripts) {
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>GaitSLAM: "
      "{}</title>\n"
      "<link rel=\"icon\" href=\"data:,\">\n<style>\n{}{}</style>\n</head>\n<body>\n"
      "<header><h1>{}</h1>\n<p class='soft'>{}</p></header>\n{}",
      content_security_policy(scripts), escaped(title), gaitslam_page_style(), figure_style(), escaped(title),
      subtitle, body);
  for (const std::string_view script : scripts) html.append("<script>").append(script).append("</script>\n");
  return html + "</body>\n</html>\n";
}

}  // namespace sim::pages
