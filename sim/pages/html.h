// The builder of all HTML pages: escaping, tables, figures, and the frame of a page that is one file.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/pages/figure.h"

namespace sim::pages {

/// RFC 4648.
std::string base64(std::string_view bytes);
/// A script element with JSON as data under that id. Browsers never run it, whatever the JSON contains.
std::string data_script(std::string_view id, std::string_view json);

/// A cell of a table: HTML with its style class.
struct TableCell {
  std::string html, style = "";
};
TableCell text_cell(std::string_view text, const std::string& style = "");
TableCell code_cell(std::string_view text);
/// Four significant digits; a dash if there is no finite value.
TableCell number_cell(std::optional<double> value);
std::string number_text(std::optional<double> value);

struct TableRow {
  std::vector<TableCell> cells;
  std::string id = "";
};
/// The first column stays visible when the table is scrolled.
std::string table_html(std::string_view name, const std::vector<TableCell>& titles,
                       const std::vector<TableRow>& rows);

/// A figure with caption, drawing and legend, followed by `below` (HTML).
std::string figure_html(const Figure& figure, const std::string& below = "", double height = 300,
                        double width = 560);
/// HTML of figures as a grid.
std::string figures_html(const std::string& figures);
/// A section of a page; html: its content.
struct Section {
  std::string id, title, html;
};
/// The sections that have a content; with links to them if there are several.
std::string sections_html(const std::vector<Section>& sections, bool with_links = false);

/// The scripts of the pages: behavior of tables and figures, and the map in three dimensions.
std::string_view page_script();
std::string_view map_script();

/// A page that is one file. subtitle, body: HTML. The Content-Security-Policy names the scripts by their
/// hashes, so that a browser runs no other script, loads nothing and sends nothing.
std::string html_page(std::string_view title, const std::string& subtitle, const std::string& body,
                      const std::vector<std::string_view>& scripts = {page_script()});

}  // namespace sim::pages
