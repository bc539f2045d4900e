#include "sim/report/page.h"

#include "sim/report/bundle.h"
#include "sim/report/html.h"
#include "sim/report/page_data.h"

namespace sim::report {

std::string page(const std::vector<RunData>& runs) {
  const auto data = page_data(runs);
  std::string html = html_head(data["title"].get<std::string>(), "", "", page_script());
  html.append(data_script("data", data)).append(kScriptBegin).append(page_script()).append(kScriptEnd);
  return html + kHtmlEnd;
}

}  // namespace sim::report
