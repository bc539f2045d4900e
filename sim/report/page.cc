#include "sim/report/page.h"

#include "sim/report/page_data.h"

namespace sim::report {
namespace {

// What would end the script element that holds it is written otherwise; JSON means the same.
std::string inside_script(const std::string& json) {
  std::string text;
  for (const char c : json) text += c == '<' ? "\\u003c" : std::string(1, c);
  return text;
}

}  // namespace

std::string page(const std::vector<RunData>& runs) {
  const auto data = page_data(runs);
  std::string html =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>GaitSLAM: " +
      data["title"].get<std::string>() + "</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n";
  html.append(page_style()).append("</style>\n</head>\n<body>\n");
  html.append("<script type=\"application/json\" id=\"data\">")
      .append(inside_script(data.dump()))
      .append("</script>\n");
  html.append("<script>\n").append(page_script()).append("</script>\n</body>\n</html>\n");
  return html;
}

}  // namespace sim::report
