// What all HTML pages share.
#pragma once

#include <string>

namespace sim::report {

/// The text with the characters escaped that end text or an attribute in quotes.
std::string escaped(const std::string& text);

/// A page up to the begin of its body: the style of all reports, followed by `more_style`. theme: "light" or
/// "dark"; empty: as the browser prefers.
std::string html_head(const std::string& title, const std::string& more_style, const std::string& theme = "");
inline constexpr const char* kHtmlEnd = "</body>\n</html>\n";

}  // namespace sim::report
