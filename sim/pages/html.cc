#include "sim/pages/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <regex>
#include <sstream>

#include "sim/files/hash.h"
#include "sim/files/text.h"

// The frame of each page, and the files that esbuild generates from web/.
GAITSLAM_EMBED(gaitslam_page_frame, GAITSLAM_PAGE_FRAME)
GAITSLAM_EMBED(gaitslam_page_script, GAITSLAM_BUNDLE "/pages.js")
GAITSLAM_EMBED(gaitslam_page_style, GAITSLAM_BUNDLE "/pages.css")

namespace sim::pages {
namespace {

constexpr double kMargin = 0.05;  // fraction of the range, on both sides
constexpr double kLeft = 72, kRight = 14, kBottom = 46;
constexpr double kLine = 18, kTitleLeft = 8, kCharacter = 7.6, kLegendMark = 26;  // px, of title and legend

const char* role_name(Role role) {
  constexpr const char* kNames[] = {"truth", "plan", "estimate", "first", "second", "third"};
  return kNames[static_cast<int>(role)];
}

/// Returns the smallest 1, 2 or 5 times a power of ten that is not below `rough`.
double round_step(double rough) {
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= rough) return factor * power;
  return 10 * power;
}

/// Returns powers of ten and, over fewer than two decades, also 2 and 5 times these.
std::vector<double> decades(double low, double high) {
  std::vector<double> ticks;
  for (double exponent = std::floor(std::log10(low)); exponent <= std::floor(std::log10(high)); ++exponent)
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double tick = factor * std::pow(10, exponent);
      if (tick >= low && tick <= high && (factor == 1 || high < 100 * low)) ticks.push_back(tick);
    }
  return ticks;
}

std::string tick_text(double value) { return fmt::format("{:.6g}", std::abs(value) < 1e-12 ? 0 : value); }

/// Returns a color twice: plain, for programs without support for CSS variables, then as defined by the page.
std::string color(const std::string& property, const std::string& variable, const std::string& plain) {
  return fmt::format("{0}:{2};{0}:var(--{1},{2})", property, variable, plain);
}

std::string text(double x, double y, std::string_view words, const char* more = "text-anchor='middle'") {
  return fmt::format("<text x='{:.1f}' y='{:.1f}' {}>{}</text>", x, y, more, escaped(words));
}

/// Title and legend of a static picture, on as many lines as they need.
struct Header {
  std::string svg;
  double bottom = 12;  ///< px
};

Header header_of(const Figure& figure, double width, bool is_titled) {
  const auto most = static_cast<std::size_t>((width - kTitleLeft - kRight) / kCharacter);
  std::istringstream words(figure.title);
  std::vector<std::string> lines{""};
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + word.size() >= most) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  Header header;
  double x = kTitleLeft, y = 0;
  if (!is_titled) lines.clear();
  for (const std::string& line : lines) header.svg += text(kTitleLeft, y += kLine, line, "class='title'");
  for (const std::string& remark : figure.remarks)
    if (is_titled) header.svg += text(kTitleLeft, y += kLine, remark, "text-anchor='start'");
  y += kLine;
  for (const Line& line : figure.lines) {
    if (line.name.empty()) continue;
    const double length = kCharacter * static_cast<double>(line.name.size()) + kLegendMark;
    if (x > kTitleLeft && x + length > width) x = kTitleLeft, y += kLine;
    header.svg += fmt::format("<rect class='fill {}' x='{:.1f}' y='{:.0f}' width='12' height='8'/>",
                              role_name(line.role), x, y - 8) +
                  text(x + 16, y, line.name, "");
    x += length;
  }
  header.bottom += y;
  return header;
}

struct Axes {
  Axis x, y;
};

// Gives both axes the same scale by widening the range of one of them about its middle.
void make_equal(Axes& axes) {
  const double x_scale = std::abs(axes.x.end - axes.x.begin) / (axes.x.high - axes.x.low);
  const double y_scale = std::abs(axes.y.end - axes.y.begin) / (axes.y.high - axes.y.low);
  Axis& wide = x_scale > y_scale ? axes.x : axes.y;
  const double factor = std::max(x_scale, y_scale) / std::min(x_scale, y_scale);
  const double middle = (wide.low + wide.high) / 2, half = factor * (wide.high - wide.low) / 2;
  wide.low = middle - half;
  wide.high = middle + half;
}

Axes axes_of(const Figure& figure, double width, double height, double top) {
  std::vector<const std::vector<double>*> x, y;
  std::vector<double> levels;
  for (const Mark& level : figure.levels) levels.push_back(level.at);
  for (const Line& line : figure.lines) x.push_back(&line.x), y.push_back(&line.y);
  for (const Envelope& e : figure.envelopes) x.push_back(&e.x), y.push_back(&e.low), y.push_back(&e.high);
  y.push_back(&levels);
  Axes axes{axis_of(x, figure.logarithmic_x), axis_of(y, figure.logarithmic)};
  axes.x.begin = kLeft, axes.x.end = width - kRight;
  axes.y.begin = height - kBottom, axes.y.end = top;
  axes.x.whole = figure.whole_x, axes.y.whole = figure.whole_y;
  if (figure.equal_axes) make_equal(axes);
  return axes;
}

std::string grid(const Axes& axes) {
  std::string svg = "<g class='ticks'>";
  for (const double v : axes.x.ticks(8))
    svg += fmt::format("<path class='grid' d='M{:.1f} {:.1f}V{:.1f}'/>", axes.x.at(v), axes.y.begin,
                       axes.y.end) +
           text(axes.x.at(v), axes.y.begin + 16, tick_text(v));
  svg += "</g>";
  for (const double v : axes.y.ticks(6))
    svg += fmt::format("<path class='grid' d='M{:.1f} {:.1f}H{:.1f}'/>", axes.x.begin, axes.y.at(v),
                       axes.x.end) +
           text(axes.x.begin - 6, axes.y.at(v) + 4, tick_text(v), "text-anchor='end'");
  return svg;
}

/// Returns a path through the points, omitting points less than half a pixel from the previous one.
std::string path(const Axes& axes, const std::vector<double>& x, const std::vector<double>& y) {
  std::string d;
  double last_x = -1e9, last_y = -1e9;
  bool pen_down = false;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double px = axes.x.at(x[i]), py = axes.y.at(y[i]);
    if (!std::isfinite(py)) {
      pen_down = false;
      continue;
    }
    if (pen_down && std::hypot(px - last_x, py - last_y) < 0.5 && i + 1 < x.size()) continue;
    d += fmt::format("{}{:.1f} {:.2f}", pen_down ? 'L' : 'M', px, py);
    last_x = px, last_y = py, pen_down = true;
  }
  return d;
}

// Draws dots as strokes of zero length with round ends.
std::string dots(const Axes& axes, const std::vector<double>& x, const std::vector<double>& y) {
  std::string d;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::isfinite(x[i]) && std::isfinite(y[i]))
      d += fmt::format("M{:.1f} {:.2f}h0", axes.x.at(x[i]), axes.y.at(y[i]));
  return d;
}

std::string draw(const Axes& axes, const Envelope& e) {
  std::string d;
  for (std::size_t i = 0, begin = 0; i <= e.x.size(); ++i) {
    if (i < e.x.size() && std::isfinite(e.low[i] + e.high[i])) continue;
    std::vector<double> x(e.x.begin() + begin, e.x.begin() + i),
        y(e.high.begin() + begin, e.high.begin() + i);
    for (std::size_t k = i; k-- > begin;) x.push_back(e.x[k]), y.push_back(e.low[k]);
    if (!x.empty()) d += path(axes, x, y) + "Z";
    begin = i + 1;  // the area is interrupted at each gap
  }
  return d.empty() ? ""
                   : fmt::format("<path class='fill envelope {}' data-name='{}' d='{}'/>", role_name(e.role),
                                 escaped(e.name), d);
}

std::string draw(const Axes& axes, const Line& line) {
  return fmt::format("<path class='{} {}' data-name='{}' d='{}'/>",
                     line.dots   ? "dots"
                     : line.thin ? "line thin"
                                 : "line",
                     role_name(line.role), escaped(line.name),
                     line.dots ? dots(axes, line.x, line.y) : path(axes, line.x, line.y));
}

std::string lines_svg(const Figure& figure, const Axes& axes) {
  const std::string place = fmt::format("x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}'", axes.x.begin,
                                        axes.y.end, axes.x.end - axes.x.begin, axes.y.begin - axes.y.end);
  // An inner document clips the lines; web/figures.js zooms with its viewBox.
  std::string svg =
      grid(axes) +
      fmt::format("<svg class='data' {} viewBox='{:.1f} {:.1f} {:.1f} {:.1f}' preserveAspectRatio='none'>",
                  place, axes.x.begin, axes.y.end, axes.x.end - axes.x.begin, axes.y.begin - axes.y.end);
  const auto add = [&](const auto& parts) {
    for (const auto& part : parts) svg += draw(axes, part);
  };
  add(figure.envelopes);
  for (const Mark& level : figure.levels)
    svg += fmt::format("<path class='level' d='M{:.1f} {:.1f}H{:.1f}'><title>{}</title></path>", axes.x.begin,
                       axes.y.at(level.at), axes.x.end, escaped(level.name));
  for (const Mark& moment : figure.moments)
    svg += fmt::format("<path class='level' d='M{:.1f} {:.1f}V{:.1f}'/>", axes.x.at(moment.at), axes.y.begin,
                       axes.y.end);
  add(figure.lines);
  svg += fmt::format("</svg><rect class='frame' {}/>", place);
  double y = axes.y.end;  // names are stacked, so that names of neighboring moments do not overlap
  for (const Mark& moment : figure.moments)
    svg += text(axes.x.at(moment.at) + 4, y += 14, moment.name, "class='moment'");
  return svg;
}

// Returns the axes as attributes for web/figures.js.
std::string attributes(const Figure& figure, const Axes& axes) {
  if (figure.equal_axes) return "";
  const auto of = [](const char* name, const Axis& a) {
    return fmt::format(" data-{}='{} {} {} {} {:d}'", name, a.low, a.high, a.begin, a.end, a.logarithmic);
  };
  return of("x", axes.x) + of("y", axes.y) + (figure.is_over_time() ? " data-over-time='yes'" : "");
}

constexpr double kWidth = 560, kHeight = 300, kEqualHeight = 480;  // px of a figure

/// Allows line breaks after dots and underscores in the names within HTML.
std::string breakable(const std::string& html) {
  static const std::regex kPlaces("[._](?![^<]*>)(?=[a-z])");
  return std::regex_replace(html, kPlaces, "$&<wbr>");
}

std::string row_html(const TableRow& row, const char* tag) {
  std::string html = "<tr>";
  for (const TableCell& cell : row.cells)
    html += fmt::format("<{0}{1}>{2}</{0}>", tag,
                        cell.style.empty() ? "" : fmt::format(" class='{}'", cell.style), cell.html);
  return html + "</tr>\n";
}

/// Returns the curves of the legend as columns for web/figures.js: float32 in Base64, and each part's
/// columns.
std::string columns_html(const Figure& figure) {
  std::map<std::string, std::size_t> numbers;  // by their bytes
  std::string columns, parts;
  const auto add = [&](const std::string& name, std::initializer_list<const std::vector<double>*> of) {
    if (name.empty()) return;
    std::string part;
    for (const std::vector<double>* column : of) {
      const std::vector<float> values(column->begin(), column->end());
      const std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
      const auto [known, is_new] = numbers.try_emplace(bytes, numbers.size());
      part += fmt::format("{}{}", part.empty() ? "" : " ", known->second);
      if (is_new) columns += (known->second == 0 ? "" : " ") + base64(bytes);
    }
    parts += (parts.empty() ? "" : ";") + part;
  };
  for (const Line& line : figure.lines) add(line.name, {&line.x, &line.y});
  for (const Envelope& e : figure.envelopes) add(e.name, {&e.x, &e.low, &e.high});
  return parts.empty() || figure.equal_axes
             ? ""
             : fmt::format(" data-columns='{}' data-parts='{}'", columns, parts);
}

std::string legend_html(const Figure& figure) {
  std::string items;
  const auto add = [&](const auto& named) {
    for (const auto& one : named)
      if (!one.name.empty())
        items +=
            fmt::format("<span class='role-{}'>{} <b></b></span> ", role_name(one.role), escaped(one.name));
  };
  add(figure.lines), add(figure.envelopes);
  return items.empty() ? "" : "<p class='legend'><span class='at'></span> " + items + "</p>";
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : files::sanitize(std::string(text)))
    out += c == '&'    ? "&amp;"
           : c == '<'  ? "&lt;"
           : c == '>'  ? "&gt;"
           : c == '"'  ? "&quot;"
           : c == '\'' ? "&#39;"
                       : std::string(1, c);
  return out;
}

double Axis::at(double value) const {
  const auto scale = [&](double v) { return logarithmic ? std::log(std::max(v, low * 1e-3)) : v; };
  return begin + (end - begin) * (scale(value) - scale(low)) / (scale(high) - scale(low));
}

std::vector<double> Axis::ticks(int about) const {
  if (logarithmic)
    if (std::vector<double> ticks = decades(low, high); ticks.size() > 1) return ticks;
  const double step =
      whole ? std::max(1.0, round_step((high - low) / about)) : round_step((high - low) / about);
  std::vector<double> ticks;
  for (double k = std::ceil(low / step); k * step <= high; ++k) ticks.push_back(k * step);
  return ticks;
}

Axis axis_of(const std::vector<const std::vector<double>*>& values, bool logarithmic) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto* column : values) {
    for (const double value : *column) {
      if (!std::isfinite(value) || (logarithmic && value <= 0)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (low > high) return {};
  if (logarithmic) return {low / 1.5, high * 1.5, 0, 1, true};
  const double margin = high > low ? kMargin * (high - low) : std::max(1e-3, 0.1 * std::abs(high));
  return {low - margin, high + margin};
}

std::string figure_style() {
  std::string css =
      "svg{font-family:sans-serif;font-size:12px}text{" + color("fill", "text", "#333") + "}.paper{" +
      color("fill", "panel", "#fff") + "}.grid{stroke-width:1;" + color("stroke", "edge", "#ddd") +
      "}.frame{fill:none;stroke:#999}.line{fill:none;stroke-width:1.6}.thin{stroke-width:1}.envelope{opacity:"
      ".2}.dots{fill:none;stroke-width:4.4;stroke-linecap:round}.line,.dots,.level{vector-effect:non-scaling-"
      "stroke}.level{stroke:#777;stroke-dasharray:5 "
      "4;fill:none}.title{font-weight:600;font-size:13px}.moment{paint-order:stroke;stroke-width:4;" +
      color("stroke", "panel", "#fff") + "}";
  constexpr std::array kColors{"#333", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00"};
  for (std::size_t i = 0; i < kColors.size(); ++i) {
    const std::string name = role_name(static_cast<Role>(i));
    css += ".line." + name + ",.dots." + name + "{" + color("stroke", name, kColors[i]) + "}";
    css += ".fill." + name + "{" + color("fill", name, kColors[i]) + "}";
  }
  return css;
}

std::string to_svg(const Figure& figure, double width, double height, Surroundings surroundings) {
  const bool in_page = surroundings == Surroundings::page;
  const Header header = in_page ? Header{} : header_of(figure, width, surroundings == Surroundings::titled);
  const Axes axes = axes_of(figure, width, height, header.bottom);
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' "
      "height='{1:.0f}' role='img' aria-label='{2}'{3}>{4}<rect class='paper' width='100%' height='100%'/>",
      width, height, escaped(figure.title), in_page ? attributes(figure, axes) : "",
      in_page ? "" : "<style>" + figure_style() + "</style>");
  svg += lines_svg(figure, axes) + header.svg +
         text((axes.x.begin + axes.x.end) / 2, height - 10, figure.x_label);
  return svg +
         fmt::format("<text transform='translate(14 {:.1f})rotate(-90)' text-anchor='middle'>{}</text>",
                     (axes.y.begin + axes.y.end) / 2, escaped(figure.y_label)) +
         "</svg>\n";
}

std::string base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

TableCell text_cell(std::string_view text, const std::string& style) { return {escaped(text), style}; }
TableCell code_cell(std::string_view text) { return {"<code>" + escaped(text) + "</code>"}; }
TableCell number_cell(std::optional<double> value) { return {number_text(value), "number"}; }

std::string table_html(std::string_view name, const std::vector<std::string>& titles,
                       const std::vector<TableRow>& rows, bool sorts) {
  std::string html = fmt::format(
      "<div class='scroll' tabindex='0' role='region' aria-label='{}'><table class='named-rows{}'><thead>",
      escaped(name), sorts && rows.size() > 1 ? " sortable" : "");
  TableRow head;
  for (std::size_t i = 0; i < titles.size(); ++i) {
    const bool of_numbers = !rows.empty() && rows[0].cells[i].style.starts_with("number");
    TableCell& title = head.cells.emplace_back(text_cell(titles[i], of_numbers ? "number" : ""));
    title.html = breakable(title.html);
  }
  html += row_html(head, "th") + "</thead><tbody>\n";
  for (TableRow row : rows) {
    row.cells[0].html = breakable(row.cells[0].html);
    html += row_html(row, "td");
  }
  return html + "</tbody></table></div>\n";
}

std::string figure_html(const Figure& figure) {
  if (figure.lines.empty()) return "";
  std::string remarks;
  for (const std::string& remark : figure.remarks)
    remarks += fmt::format("<p class='soft'>{}</p>", escaped(remark));
  return fmt::format("<figure data-figure='{}'{}><figcaption>{}</figcaption>{}{}{}</figure>\n",
                     escaped(figure.name), columns_html(figure), escaped(figure.title), remarks,
                     to_svg(figure, kWidth, figure.equal_axes ? kEqualHeight : kHeight, Surroundings::page),
                     legend_html(figure));
}

std::string figures_html(const std::string& figures) {
  return figures.empty() ? "" : "<div class='figures'>" + figures + "</div>\n";
}

std::string sections_html(const std::vector<Section>& sections, bool with_links) {
  std::string links = "<nav aria-label='sections'>", html;
  int count = 0;
  for (const Section& section : sections) {
    if (section.html.empty()) continue;
    ++count;
    links += fmt::format("<a href='#{}'>{}</a> ", escaped(section.id), escaped(section.title));
    html += fmt::format("<section id='{}'><h2>{}</h2>\n{}</section>\n", escaped(section.id),
                        escaped(section.title), section.html);
  }
  return (with_links && count > 1 ? links + "</nav>\n" : "") + html;
}

std::string html_page(std::string_view title, const std::string& subtitle, const std::string& body) {
  const std::string_view script = gaitslam_page_script();
  return fmt::format(fmt::runtime(gaitslam_page_frame()), fmt::arg("hash", base64(files::sha256(script))),
                     fmt::arg("title", escaped(title)), fmt::arg("subtitle", subtitle),
                     fmt::arg("style", std::string(gaitslam_page_style()) + figure_style()),
                     fmt::arg("body", body), fmt::arg("script", script));
}

}  // namespace sim::pages
