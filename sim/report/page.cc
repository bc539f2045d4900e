#include "sim/report/page.h"

#include "sim/report/bundle.h"
#include "sim/report/html.h"
#include "sim/report/page_data.h"

namespace sim::report {
namespace {

// Escapes what would end the script element that holds the JSON.
std::string inside_script(const std::string& json) {
  std::string text;
  for (const char c : json) text += c == '<' ? "\\u003c" : std::string(1, c);
  return text;
}

}  // namespace

std::string page(const std::vector<RunData>& runs) {
  const auto data = page_data(runs);
  std::string html = html_head(data["title"].get<std::string>(), "");
  html.append("<script type=\"application/json\" id=\"data\">")
      .append(inside_script(data.dump()))
      .append("</script>\n<script>\n")
      .append(page_script())
      .append("</script>\n");
  return html + kHtmlEnd;
}

}  // namespace sim::report
