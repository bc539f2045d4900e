#include "sim/report/html.h"

#include <fmt/core.h>

#include "sim/report/bundle.h"

namespace sim::report {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '\'' ? "&#39;" : std::string(1, c);
  return out;
}

std::string html_head(const std::string& title, const std::string& more_style, const std::string& theme) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"{}>\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>GaitSLAM: "
      "{}</title>\n"
      "<link rel=\"icon\" href=\"data:,\">\n<style>\n{}{}</style>\n</head>\n<body>\n",
      theme.empty() ? "" : fmt::format(" data-theme=\"{}\"", theme), escaped(title), page_style(),
      more_style);
}

}  // namespace sim::report
