#include "sim/pages/html.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "sim/files/json.h"
#include "sim/files/sha256.h"
#include "sim/pages/bundle.h"
#include "sim/pages/pictures.h"

namespace sim::pages {
namespace {

// Pictures are part of the page, figures bring their own styles; nothing else is loaded, and no script runs
// but the one with this hash. Policies in a page cannot say who may show it in a frame.
std::string content_security_policy(std::string_view script) {
  const std::string scripts =
      script.empty() ? "'none'" : fmt::format("'sha256-{}'", base64(files::sha256(script)));
  return fmt::format(
      "default-src 'none'; script-src {}; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
      "form-action 'none'",
      scripts);
}

// The parser of a browser would end such a script early, or read it otherwise than its hash says.
void require_embeddable(std::string_view script) {
  for (const std::string_view breaking : {"</script", "<!--", "\r"})
    if (script.find(breaking) != script.npos)
      throw std::logic_error(fmt::format("the script of the pages contains {}", breaking));
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  return out;
}

// No "<" is left: neither "</script>" nor "<!--" ends the element or begins a comment in it.
std::string data_script(const std::string& id, const nlohmann::ordered_json& json) {
  std::string text = fmt::format("<script type=\"application/json\" id=\"{}\">", escaped(id));
  for (const char c : files::json_text(json)) text += c == '<' ? "\\u003c" : std::string(1, c);
  return text + "</script>\n";
}

std::string html_head(const std::string& title, const std::string& more_style, const std::string& theme,
                      std::string_view script) {
  require_embeddable(script);
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"{}>\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>GaitSLAM: "
      "{}</title>\n"
      "<link rel=\"icon\" href=\"data:,\">\n<style>\n{}{}</style>\n</head>\n<body>\n",
      theme.empty() ? "" : fmt::format(" data-theme=\"{}\"", escaped(theme)), content_security_policy(script),
      escaped(title), page_style(), more_style);
}

}  // namespace sim::pages
