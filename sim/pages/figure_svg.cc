#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "sim/pages/figure.h"
#include "sim/pages/html.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

constexpr double kLeft = 62, kRight = 14, kBottom = 46;
constexpr double kNames = 84;  // px left of the rows of a heat map
constexpr double kLine = 18;   // px of the title's lines
constexpr double kTitleLeft = 8, kTitleCharacter = 7.6, kLegendCharacter = 7, kLegendMark = 26;

// A color twice: plain, for programs that do not know CSS variables, then as the surrounding page defines it.
std::string color(const std::string& property, const std::string& variable, const std::string& plain) {
  return fmt::format("{0}:{2};{0}:var(--{1},{2})", property, variable, plain);
}

std::string text(double x, double y, std::string_view words, const char* more = "text-anchor='middle'") {
  return fmt::format("<text x='{:.1f}' y='{:.1f}' {}>{}</text>", x, y, more, escaped(words));
}

double legend_width(const Line& line) {
  return line.name.empty() ? 0 : kLegendCharacter * static_cast<double>(line.name.size()) + kLegendMark;
}

/// Title and legend above the axes: the title in as many lines as it needs, the legend beside or below its
/// last line. A page has both outside of the drawing.
struct Header {
  explicit Header(bool of_page) : in_page(of_page) {}
  Header(const Figure& figure, double width) {
    const double room = width - kTitleLeft - kRight;
    const auto fits = [&](const std::string& line) {
      return kTitleCharacter * static_cast<double>(line.size()) <= room;
    };
    std::istringstream words(figure.title);
    for (std::string word; words >> word;)
      if (title.empty() || !fits(title.back() + " " + word))
        title.push_back(word);
      else
        title.back() += " " + word;
    double legend = 0;
    for (const Line& line : figure.lines) legend += legend_width(line);
    const double last = title.empty() ? 0 : kTitleCharacter * static_cast<double>(title.back().size());
    const auto lines = static_cast<double>(std::max<std::size_t>(title.size(), 1));
    legend_y = kLine * (last + legend > room ? lines + 1 : lines);
    bottom = legend_y + 12;
  }
  bool in_page = false;
  std::vector<std::string> title;
  double legend_y = 0, bottom = 12;  ///< px
};

std::string header_svg(const Header& header, const Figure& figure, double width) {
  if (header.in_page) return "";
  std::string svg;
  double x = width - kRight, y = 0;
  for (const std::string& line : header.title) svg += text(kTitleLeft, y += kLine, line, "class='title'");
  for (auto line = figure.lines.rbegin(); line != figure.lines.rend(); ++line) {
    if (line->name.empty()) continue;
    x -= legend_width(*line);
    svg += fmt::format("<rect class='fill {}' x='{:.1f}' y='{:.0f}' width='12' height='8'/>",
                       role_name(line->role), x, header.legend_y - 8) +
           text(x + 16, header.legend_y, line->name, "");
  }
  return svg;
}

struct Axes {
  Axis x, y;
};

// A meter is as long in x as in y: widens the narrower axis about its middle.
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
  for (const Level& level : figure.levels) levels.push_back(level.y);
  for (const Line& line : figure.lines) x.push_back(&line.x), y.push_back(&line.y);
  for (const Envelope& e : figure.envelopes) x.push_back(&e.x), y.push_back(&e.low), y.push_back(&e.high);
  for (const Box& box : figure.boxes) y.push_back(&box.values);
  y.push_back(&levels);
  Axes axes{axis_of(x, figure.logarithmic_x), axis_of(y, figure.logarithmic)};
  axes.x.begin = figure.cells.empty() ? kLeft : kNames, axes.x.end = width - kRight;
  axes.y.begin = height - kBottom, axes.y.end = top;
  axes.x.whole = figure.whole_x, axes.y.whole = figure.whole_y;
  if (figure.equal_axes) make_equal(axes);
  return axes;
}

std::string rows_of_grid(const Axes& axes) {
  std::string svg;
  for (const double v : axes.y.ticks(6))
    svg += fmt::format("<path class='grid' d='M{:.1f} {:.1f}H{:.1f}'/>", axes.x.begin, axes.y.at(v),
                       axes.x.end) +
           text(axes.x.begin - 6, axes.y.at(v) + 4, tick_text(v), "text-anchor='end'");
  return svg;
}

std::string grid(const Axes& axes) {
  std::string svg = "<g class='ticks'>";
  for (const double v : axes.x.ticks(8))
    svg += fmt::format("<path class='grid' d='M{:.1f} {:.1f}V{:.1f}'/>", axes.x.at(v), axes.y.begin,
                       axes.y.end) +
           text(axes.x.at(v), axes.y.begin + 16, tick_text(v));
  return svg + "</g>" + rows_of_grid(axes);
}

// Points of a path, without those that are nearer than half a pixel to the one before.
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

// Strokes without length: their round ends are the dots.
std::string dots(const Axes& axes, const std::vector<double>& x, const std::vector<double>& y) {
  std::string d;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::isfinite(x[i]) && std::isfinite(y[i]))
      d += fmt::format("M{:.1f} {:.2f}h0", axes.x.at(x[i]), axes.y.at(y[i]));
  return d;
}

std::string draw(const Axes& axes, const Envelope& e) {
  std::string d;
  std::vector<double> x, low, high;
  for (std::size_t i = 0; i <= e.x.size(); ++i) {
    if (i < e.x.size() && std::isfinite(e.low[i] + e.high[i])) {
      x.push_back(e.x[i]), low.push_back(e.low[i]), high.push_back(e.high[i]);
      continue;
    }
    if (x.empty()) continue;  // an area ends at each gap
    const std::vector<double> back(x.rbegin(), x.rend());
    x.insert(x.end(), back.begin(), back.end());
    high.insert(high.end(), low.rbegin(), low.rend());
    d += path(axes, x, high) + "Z";
    x.clear(), low.clear(), high.clear();
  }
  return d.empty() ? ""
                   : fmt::format("<path class='fill envelope {}' data-name='{}' d='{}'/>", role_name(e.role),
                                 escaped(e.name), d);
}

std::string draw(const Axes& axes, const Line& line) {
  return fmt::format("<path class='{} {}' data-name='{}' d='{}'/>", line.dots ? "dots" : "line",
                     role_name(line.role), escaped(line.name),
                     line.dots ? dots(axes, line.x, line.y) : path(axes, line.x, line.y));
}

std::string draw(const Axes& axes, const Level& level) {
  return fmt::format("<path class='level' d='M{:.1f} {:.1f}H{:.1f}'><title>{}</title></path>", axes.x.begin,
                     axes.y.at(level.y), axes.x.end, escaped(level.name));
}

std::string draw(const Axes& axes, const Moment& moment) {
  return fmt::format("<path class='level' d='M{:.1f} {:.1f}V{:.1f}'/>", axes.x.at(moment.x), axes.y.begin,
                     axes.y.end);
}

std::string frame(const Axes& axes) {
  return fmt::format("<rect class='frame' x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}'/>",
                     axes.x.begin, axes.y.end, axes.x.end - axes.x.begin, axes.y.begin - axes.y.end);
}

std::string lines_svg(const Figure& figure, const Axes& axes) {
  // An inner document clips the lines; web/figures.js zooms by its viewBox.
  std::string svg =
      grid(axes) +
      fmt::format(
          "<svg class='data' x='{0:.1f}' y='{1:.1f}' width='{2:.1f}' height='{3:.1f}' viewBox='{0:.1f} "
          "{1:.1f} {2:.1f} {3:.1f}' preserveAspectRatio='none'>",
          axes.x.begin, axes.y.end, axes.x.end - axes.x.begin, axes.y.begin - axes.y.end);
  const auto add = [&](const auto& parts) {
    for (const auto& part : parts) svg += draw(axes, part);
  };
  add(figure.envelopes), add(figure.levels), add(figure.moments), add(figure.lines);
  svg += "</svg>" + frame(axes);
  for (const Moment& moment : figure.moments)
    svg += text(axes.x.at(moment.x) + 4, axes.y.end + 14, moment.name, "class='moment'");
  return svg;
}

// Box from the first to the third quartile, a thick line at the median, whiskers to the least and the
// greatest value, and the values as dots beside it.
std::string draw(const Axes& axes, const Box& box, double middle, double half) {
  std::string svg = text(middle, axes.y.begin + 16, box.name);
  if (box.values.empty()) return svg;
  const auto at = [&](double q) { return axes.y.at(score::quantile(box.values, q)); };
  const char* const role = role_name(box.role);
  svg += fmt::format("<path class='line {0}' d='M{1:.1f} {2:.1f}V{3:.1f}M{1:.1f} {4:.1f}V{5:.1f}'/>", role,
                     middle, at(0), at(0.25), at(0.75), at(1));
  svg += fmt::format("<rect class='fill envelope {}' x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}'/>",
                     role, middle - half, at(0.75), 2 * half, std::max(1.0, at(0.25) - at(0.75)));
  svg += fmt::format("<path class='line median {}' d='M{:.1f} {:.1f}H{:.1f}'/><path class='dots {} few' d='",
                     role, middle - half, at(0.5), middle + half, role);
  for (const double value : box.values)
    svg += fmt::format("M{:.1f} {:.1f}h0", middle + 1.35 * half, axes.y.at(value));
  return svg + "'/>";
}

std::string boxes_svg(const Figure& figure, const Axes& axes) {
  std::string svg = rows_of_grid(axes);
  const double each = (axes.x.end - axes.x.begin) / static_cast<double>(figure.boxes.size());
  for (std::size_t i = 0; i < figure.boxes.size(); ++i)
    svg += draw(axes, figure.boxes[i], axes.x.begin + (static_cast<double>(i) + 0.5) * each,
                std::min(40.0, 0.25 * each));
  return svg + frame(axes);
}

// From light (the least value) to dark.
std::string cell_color(double part) {
  const auto mix = [part](double from, double to) { return static_cast<int>(from + part * (to - from)); };
  return fmt::format("rgb({},{},{})", mix(253, 84), mix(231, 2), mix(150, 75));
}

// Position of a loss between the least and the greatest one, 0 to 1; logarithmic if all are positive.
double part_of_range(const Figure& figure, double loss) {
  double low = INFINITY, high = -INFINITY;
  for (const Cell& cell : figure.cells)
    if (std::isfinite(cell.value)) low = std::min(low, cell.loss), high = std::max(high, cell.loss);
  if (!(high > low)) return 0;
  return low > 0 ? std::log(loss / low) / std::log(high / low) : (loss - low) / (high - low);
}

std::string draw(const Figure& figure, const Cell& cell, double x, double y, double width, double height) {
  const bool known = std::isfinite(cell.value);
  const double part = known ? part_of_range(figure, cell.loss) : 0;
  const char* const ink = !known ? "" : part > 0.5 ? "style='fill:#fff'" : "style='fill:#000'";
  const std::string inside =
      fmt::format("<rect class='cell' x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' style='fill:{}'/>",
                  x, y, width, height, known ? cell_color(part) : "none") +
      text(x + width / 2, y + height / 2 + 4, known ? fmt::format("{:.3g}", cell.value) : "-",
           fmt::format("text-anchor='middle' {}", ink).c_str());
  return cell.href.empty() ? inside : fmt::format("<a href='{}'>{}</a>", escaped(cell.href), inside);
}

std::string cells_svg(const Figure& figure, const Axes& axes) {
  const double across = (axes.x.end - axes.x.begin) / static_cast<double>(figure.columns.size()),
               down = (axes.y.begin - axes.y.end) / static_cast<double>(figure.rows.size());
  const auto x = [&](std::size_t column) { return axes.x.begin + across * static_cast<double>(column); };
  const auto y = [&](std::size_t row) { return axes.y.begin - down * static_cast<double>(row + 1); };
  std::string svg;
  for (std::size_t i = 0; i < figure.columns.size(); ++i)
    svg += text(x(i) + across / 2, axes.y.begin + 16, figure.columns[i]);
  for (std::size_t i = 0; i < figure.rows.size(); ++i)
    svg += text(kNames - 6, y(i) + down / 2 + 4, figure.rows[i], "text-anchor='end'");
  for (const Cell& cell : figure.cells) svg += draw(figure, cell, x(cell.column), y(cell.row), across, down);
  return svg;
}

std::string attributes(const Figure& figure, const Axes& axes) {
  if (!figure.boxes.empty() || !figure.cells.empty() || figure.equal_axes) return "";
  const auto of = [](const char* name, const Axis& a) {
    return fmt::format(" data-{}='{} {} {} {} {:d}'", name, a.low, a.high, a.begin, a.end, a.logarithmic);
  };
  return of("x", axes.x) + of("y", axes.y) + (figure.is_over_time() ? " data-over-time='yes'" : "");
}

std::string draw(const Figure& figure, double width, double height, const Header& header) {
  const Axes axes = axes_of(figure, width, height, header.bottom);
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' "
      "height='{1:.0f}' role='img' aria-label='{2}'{3}>{4}<rect class='paper' width='100%' height='100%'/>",
      width, height, escaped(figure.title), header.in_page ? attributes(figure, axes) : "",
      header.in_page ? "" : "<style>" + figure_style() + "</style>");
  svg += !figure.boxes.empty()   ? boxes_svg(figure, axes)
         : !figure.cells.empty() ? cells_svg(figure, axes)
                                 : lines_svg(figure, axes);
  svg += header_svg(header, figure, width);
  svg += text((axes.x.begin + axes.x.end) / 2, height - 10, figure.x_label);
  return svg +
         fmt::format("<text transform='translate(14 {:.1f})rotate(-90)' text-anchor='middle'>{}</text>",
                     (axes.y.begin + axes.y.end) / 2, escaped(figure.y_label)) +
         "</svg>\n";
}

}  // namespace

const char* role_name(Role role) {
  constexpr const char* kNames[] = {"truth", "plan", "estimate", "first", "second", "third"};
  return kNames[static_cast<int>(role)];
}

std::string figure_style() {
  std::string css =
      "svg{font-family:sans-serif;font-size:12px}text{" + color("fill", "text", "#333") + "}.paper{" +
      color("fill", "panel", "#fff") + "}.grid{stroke-width:1;" + color("stroke", "edge", "#ddd") +
      "}.frame{fill:none;stroke:#999}.line{fill:none;stroke-width:1.6}.envelope{opacity:.2}.cell{stroke:#"
      "8888}"
      ".median{stroke-width:3}.dots{fill:none;stroke-width:4.4;stroke-linecap:round}.line,.dots,.level{"
      "vector-effect:non-scaling-stroke}"
      ".level{stroke:#777;stroke-dasharray:5 4;fill:none}.title{font-weight:600;font-size:13px}";
  constexpr std::array kColors{"#333", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00"};
  for (std::size_t i = 0; i < kColors.size(); ++i) {
    const std::string name = role_name(static_cast<Role>(i));
    css += ".line." + name + ",.dots." + name + "{" + color("stroke", name, kColors[i]) + "}";
    css += ".fill." + name + "{" + color("fill", name, kColors[i]) + "}";
  }
  return css;
}

std::string to_svg(const Figure& figure, double width, double height) {
  return draw(figure, width, height, Header(figure, width));
}

std::string to_page_svg(const Figure& figure, double width, double height) {
  return draw(figure, width, height, Header(true));
}

}  // namespace sim::pages
