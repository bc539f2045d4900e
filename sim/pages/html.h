// What all HTML pages share.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace sim::pages {

/// Text for HTML and SVG: shown as it is, within an element and within an attribute in quotes of either kind.
/// Whatever comes from a file or a user goes through here.
std::string escaped(std::string_view text);

/// A script element that holds JSON as data, under that id. No browser runs it, whatever the JSON says.
std::string data_script(const std::string& id, const nlohmann::ordered_json& json);

/// A page up to the begin of its body: the style of all reports, followed by `more_style`. theme: "light" or
/// "dark"; empty: as the browser prefers. script: the text of the one script element that the page may run
/// (kScriptBegin, it, kScriptEnd); empty: none. The page's Content-Security-Policy names it by its hash, so
/// that a browser runs no other script, loads nothing and sends nothing.
std::string html_head(const std::string& title, const std::string& more_style, const std::string& theme = "",
                      std::string_view script = "");
inline constexpr const char* kScriptBegin = "<script>";
inline constexpr const char* kScriptEnd = "</script>\n";
inline constexpr const char* kHtmlEnd = "</body>\n</html>\n";

}  // namespace sim::pages
