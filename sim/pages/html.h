// The builder of all HTML pages: escaping, tables, figures, and the frame of a single-file page. Also the
// plot engine for pages and pictures: figures are data, drawn as SVG.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/result/limits.h"

namespace sim::pages {

using result::number_text;

/// Returns the text escaped for elements and quoted attributes in HTML and SVG. Every text from a file or a
/// user must be escaped.
std::string escaped(std::string_view text);

/// Determines the color; style sheets and pictures assign one to each role.
enum class Role { truth, plan, estimate, first, second, third };

/// A line through points; NaN interrupts it.
struct Line {
  std::string name;
  Role role = Role::first;
  std::vector<double> x{}, y{};
  bool dots = false;  ///< draws the points only
  bool thin = false;  ///< for lines shown for comparison

  void add(double at, double value) { x.push_back(at), y.push_back(value); }
};

/// The area between two lines with the same x values, such as a 3-sigma envelope.
struct Envelope {
  std::string name;
  Role role = Role::first;
  std::vector<double> x{}, low{}, high{};

  void add(double at, double from, double to) { x.push_back(at), low.push_back(from), high.push_back(to); }
};

/// A line across the figure at one value of an axis, such as the edge of a band or the loop closure.
struct Mark {
  std::string name;
  double at = 0;
};

/// name: used as the file name. x_label, y_label: with units.
struct Figure {
  std::string name, title, x_label, y_label;
  std::vector<Line> lines{};
  std::vector<Envelope> envelopes{};
  std::vector<Mark> levels{};          ///< horizontal, at y
  std::vector<Mark> moments{};         ///< vertical, at x
  std::vector<std::string> remarks{};  ///< below the title
  bool equal_axes = false;             ///< x and y have the same scale
  bool logarithmic = false;            ///< y axis
  bool logarithmic_x = false;
  bool whole_x = false, whole_y = false;  ///< ticks are whole numbers

  bool is_over_time() const { return x_label.starts_with("time"); }
};

/// Maps values (`low` to `high`) to pixels (`begin` to `end`), linearly or logarithmically.
struct Axis {
  double low = 0, high = 1;
  double begin = 0, end = 1;
  bool logarithmic = false;
  bool whole = false;  ///< ticks are whole numbers

  double at(double value) const;
  /// Returns multiples of 1, 2 or 5 times a power of ten; on a logarithmic axis, powers of ten if two fit.
  std::vector<double> ticks(int about) const;
};

/// Returns the range of all finite values (positive ones if logarithmic) with a margin; 0 to 1 if there are
/// none.
Axis axis_of(const std::vector<const std::vector<double>*>& values, bool logarithmic);

/// The surroundings of a drawing. titled: title and legend; untitled: only a legend; page: neither, because
/// the page has figure_style(), a caption and a legend, but the axes as attributes for the cursor of
/// web/figures.js.
enum class Surroundings { titled, untitled, page };
/// Returns an SVG document of this size (px, 96 per inch).
std::string to_svg(const Figure& figure, double width, double height,
                   Surroundings surroundings = Surroundings::titled);
/// Returns the CSS for drawings: plain colors, overridden by the page's own colors if it defines them.
std::string figure_style();

/// Returns the bytes in Base64 (RFC 4648).
std::string base64(std::string_view bytes);

/// A cell of a table: HTML with its style class.
struct TableCell {
  std::string html, style = "";
};
TableCell text_cell(std::string_view text, const std::string& style = "");
TableCell code_cell(std::string_view text);
/// Returns number_text().
TableCell number_cell(std::optional<double> value);

struct TableRow {
  std::vector<TableCell> cells;
};
/// Returns a table that scrolls next to its fixed first column; titles are aligned like their cells.
/// sorts: a click on a title sorts the rows.
std::string table_html(std::string_view name, const std::vector<std::string>& titles,
                       const std::vector<TableRow>& rows, bool sorts = false);

/// Returns a figure with caption, drawing and legend; empty if it has no lines.
std::string figure_html(const Figure& figure);
/// Returns a grid of figures as HTML; empty if there are none.
std::string figures_html(const std::string& figures);
/// A section of a page; html: its content.
struct Section {
  std::string id, title, html;
};
/// Returns the sections that have content. with_links: adds links to them at the top if there are several.
std::string sections_html(const std::vector<Section>& sections, bool with_links = false);

/// Returns a single-file page. subtitle, body: HTML. The Content-Security-Policy allows only the page's
/// script, by hash, so a browser runs no other script, loads nothing and sends nothing.
std::string html_page(std::string_view title, const std::string& subtitle, const std::string& body);

}  // namespace sim::pages
