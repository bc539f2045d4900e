#include "sim/pages/page.h"

#include "sim/pages/bundle.h"
#include "sim/pages/html.h"
#include "sim/pages/page_data.h"

namespace sim::pages {

std::string page(const std::vector<RunData>& runs) {
  const auto data = page_data(runs);
  std::string html = html_head(data["title"].get<std::string>(), "", "", page_script());
  html.append(data_script("data", data)).append(kScriptBegin).append(page_script()).append(kScriptEnd);
  return html + kHtmlEnd;
}

}  // namespace sim::pages
