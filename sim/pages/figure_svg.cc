#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "sim/pages/axis.h"
#include "sim/pages/figure.h"
#include "sim/pages/html.h"
#include "sim/score/statistics.h"

namespace sim::pages {
namespace {

constexpr double kLeft = 62, kRight = 14, kBottom = 46;
constexpr double kLine = 18;  // px of the title's lines
constexpr double kTitleLeft = 8, kTitleCharacter = 7.6, kLegendCharacter = 7, kLegendMark = 26;
// A colour twice: plain, for programs that know no variables of style sheets, then as the page around it sets
// it.
std::string colour(const std::string& property, const std::string& variable, const std::string& plain) {
  return fmt::format("{0}:{2};{0}:var(--{1},{2})", property, variable, plain);
}

std::string style() {
  std::string css =
      "<style>svg{font-family:sans-serif;font-size:12px}text{" + colour("fill", "text", "#333") + "}.paper{" +
      colour("fill", "panel", "#fff") + "}.grid{stroke-width:1;" + colour("stroke", "edge", "#ddd") +
      "}.frame{fill:none;stroke:#999}.line{fill:none;stroke-width:1.6}.envelope{opacity:.2}"
      ".level{stroke:#777;stroke-dasharray:5 4;fill:none}.title{font-weight:600;font-size:13px}";
  constexpr std::array<const char*, 6> kColours{"#333",    "#d55e00", "#0072b2",
                                                "#009e73", "#cc79a7", "#e69f00"};
  for (std::size_t i = 0; i < kColours.size(); ++i) {
    const std::string name = role_name(static_cast<Role>(i));
    css += ".line." + name + "{" + colour("stroke", name, kColours[i]) + "}";
    css += ".fill." + name + "{" + colour("fill", name, kColours[i]) + "}";
  }
  return css + "</style>";
}

double legend_width(const Line& line) {
  return line.name.empty() ? 0 : kLegendCharacter * static_cast<double>(line.name.size()) + kLegendMark;
}

/// What stands above the axes: the title, in as many lines as it needs, and the legend beside or below its
/// last line.
struct Header {
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

  std::vector<std::string> title;
  double legend_y = 0, bottom = 0;  ///< px
};

struct Axes {
  Axis x, y;
};

// A metre as long in x as in y: the narrower axis is widened about its middle.
void make_equal(Axes& axes) {
  const double x_scale = std::abs(axes.x.end - axes.x.begin) / (axes.x.high - axes.x.low);
  const double y_scale = std::abs(axes.y.end - axes.y.begin) / (axes.y.high - axes.y.low);
  Axis& wide = x_scale > y_scale ? axes.x : axes.y;
  const double factor = std::max(x_scale, y_scale) / std::min(x_scale, y_scale);
  const double middle = (wide.low + wide.high) / 2, half = factor * (wide.high - wide.low) / 2;
  wide.low = middle - half;
  wide.high = middle + half;
}

Axes axes_of(const Figure& figure, double width, double height) {
  std::vector<const std::vector<double>*> x, y;
  std::vector<double> levels, moments;
  for (const Level& level : figure.levels) levels.push_back(level.y);
  for (const Line& line : figure.lines) x.push_back(&line.x), y.push_back(&line.y);
  for (const Envelope& e : figure.envelopes) x.push_back(&e.x), y.push_back(&e.low), y.push_back(&e.high);
  y.push_back(&levels);
  Axes axes{axis_of(x, figure.logarithmic_x), axis_of(y, figure.logarithmic)};
  axes.x.begin = kLeft, axes.x.end = width - kRight;
  axes.y.begin = height - kBottom, axes.y.end = Header(figure, width).bottom;
  axes.x.whole = figure.whole_x, axes.y.whole = figure.whole_y;
  if (figure.equal_axes) make_equal(axes);
  return axes;
}

std::string grid(const Axes& axes) {
  std::string svg;
  for (const double v : axes.x.ticks(8)) {
    svg += fmt::format("<path class='grid' d='M{0:.1f} {1:.1f}V{2:.1f}'/>", axes.x.at(v), axes.y.begin,
                       axes.y.end);
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}</text>", axes.x.at(v),
                       axes.y.begin + 16, tick_text(v));
  }
  for (const double v : axes.y.ticks(6)) {
    svg +=
        fmt::format("<path class='grid' d='M{:.1f} {:.1f}H{:.1f}'/>", axes.x.begin, axes.y.at(v), axes.x.end);
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end'>{}</text>", axes.x.begin - 6,
                       axes.y.at(v) + 4, tick_text(v));
  }
  return svg;
}

// Points of a path; nearer than half a pixel to the one before they are left out.
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
    d += fmt::format("{}{:.1f} {:.1f}", pen_down ? 'L' : 'M', px, py);
    last_x = px, last_y = py, pen_down = true;
  }
  return d;
}

std::string draw(const Axes& axes, const Envelope& e) {
  std::vector<double> x = e.x, y = e.high;
  x.insert(x.end(), e.x.rbegin(), e.x.rend());
  y.insert(y.end(), e.low.rbegin(), e.low.rend());
  return fmt::format("<path class='fill envelope {}' d='{}Z'/>", role_name(e.role), path(axes, x, y));
}

std::string draw(const Axes& axes, const Line& line) {
  if (!line.dots)
    return fmt::format("<path class='line {}' d='{}'/>", role_name(line.role), path(axes, line.x, line.y));
  std::string svg = fmt::format("<g class='fill {}'>", role_name(line.role));
  for (std::size_t i = 0; i < line.x.size(); ++i) {
    if (!std::isfinite(line.y[i])) continue;
    svg +=
        fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2.2'/>", axes.x.at(line.x[i]), axes.y.at(line.y[i]));
  }
  return svg + "</g>";
}

std::string draw(const Axes& axes, const Level& level) {
  return fmt::format("<path class='level' d='M{:.1f} {:.1f}H{:.1f}'><title>{}</title></path>", axes.x.begin,
                     axes.y.at(level.y), axes.x.end, escaped(level.name));
}

std::string draw(const Axes& axes, const Moment& moment) {
  return fmt::format(
      "<path class='level' d='M{0:.1f} {1:.1f}V{2:.1f}'/><text x='{3:.1f}' y='{4:.1f}'>{5}</text>",
      axes.x.at(moment.x), axes.y.begin, axes.y.end, axes.x.at(moment.x) + 4, axes.y.end + 14,
      escaped(moment.name));
}

std::string legend(const Figure& figure, double width) {
  std::string svg;
  const double y = Header(figure, width).legend_y;
  double x = width - kRight;
  for (auto line = figure.lines.rbegin(); line != figure.lines.rend(); ++line) {
    if (line->name.empty()) continue;
    x -= legend_width(*line);
    svg += fmt::format(
        "<rect class='fill {}' x='{:.1f}' y='{:.0f}' width='12' height='8'/><text x='{:.1f}' "
        "y='{:.0f}'>{}</text>",
        role_name(line->role), x, y - 8, x + 16, y, escaped(line->name));
  }
  return svg;
}

std::string begin_svg(const Figure& figure, double width, double height) {
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' "
      "height='{1:.0f}' "
      "role='img' aria-label='{2}'>{3}<rect class='paper' width='100%' height='100%'/>",
      width, height, escaped(figure.title), style());
}

std::string frame(const Axes& axes) {
  return fmt::format("<rect class='frame' x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}'/>",
                     axes.x.begin, axes.y.end, axes.x.end - axes.x.begin, axes.y.begin - axes.y.end);
}

std::string labels(const Figure& figure, const Axes& axes, double width, double height) {
  std::string svg;
  double y = 0;
  for (const std::string& line : Header(figure, width).title)
    svg += fmt::format("<text class='title' x='{:.0f}' y='{:.0f}'>{}</text>", kTitleLeft, y += kLine,
                       escaped(line));
  return svg + fmt::format(
                   "<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}</text>"
                   "<text transform='translate(14 {:.1f})rotate(-90)' text-anchor='middle'>{}</text>",
                   (axes.x.begin + axes.x.end) / 2, height - 10, escaped(figure.x_label),
                   (axes.y.begin + axes.y.end) / 2, escaped(figure.y_label));
}

Axes axes_of_boxes(const Figure& figure, double width, double height) {
  std::vector<const std::vector<double>*> values;
  for (const Box& box : figure.boxes) values.push_back(&box.values);
  Axes axes{{0, static_cast<double>(figure.boxes.size()), kLeft, width - kRight, false, false},
            axis_of(values, figure.logarithmic)};
  axes.y.begin = height - kBottom, axes.y.end = Header(figure, width).bottom;
  return axes;
}

// Box from the first to the third quartile, a thick line at the median, whiskers to the least and the
// greatest value, and the values as dots beside it.
std::string draw(const Axes& axes, const Box& box, double middle, double half) {
  std::string svg = fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}</text>", middle,
                                axes.y.begin + 16, escaped(box.name));
  if (box.values.empty()) return svg;
  const auto at = [&](double q) { return axes.y.at(score::quantile(box.values, q)); };
  const char* const role = role_name(box.role);
  svg += fmt::format("<path class='line {0}' d='M{1:.1f} {2:.1f}V{3:.1f}M{1:.1f} {4:.1f}V{5:.1f}'/>", role,
                     middle, at(0), at(0.25), at(0.75), at(1));
  svg += fmt::format("<rect class='fill envelope {}' x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}'/>",
                     role, middle - half, at(0.75), 2 * half, std::max(1.0, at(0.25) - at(0.75)));
  svg += fmt::format("<path class='line {}' style='stroke-width:3' d='M{:.1f} {:.1f}H{:.1f}'/>", role,
                     middle - half, at(0.5), middle + half);
  svg += fmt::format("<g class='fill {}'>", role);
  for (const double value : box.values)
    svg += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2.2'/>", middle + 1.35 * half, axes.y.at(value));
  return svg + "</g>";
}

std::string boxes_svg(const Figure& figure, double width, double height) {
  const Axes axes = axes_of_boxes(figure, width, height);
  std::string svg = begin_svg(figure, width, height);
  for (const double v : axes.y.ticks(6))
    svg += fmt::format(
        "<path class='grid' d='M{0:.1f} {1:.1f}H{2:.1f}'/><text x='{3:.1f}' y='{4:.1f}' "
        "text-anchor='end'>{5}</text>",
        axes.x.begin, axes.y.at(v), axes.x.end, axes.x.begin - 6, axes.y.at(v) + 4, tick_text(v));
  const double each = (axes.x.end - axes.x.begin) / static_cast<double>(figure.boxes.size());
  for (std::size_t i = 0; i < figure.boxes.size(); ++i)
    svg += draw(axes, figure.boxes[i], axes.x.begin + (static_cast<double>(i) + 0.5) * each,
                std::min(40.0, 0.25 * each));
  return svg + frame(axes) + labels(figure, axes, width, height) + "</svg>\n";
}

// From light (the least value) to dark; the text on it is black or white.
std::string cell_colour(double part) {
  const auto mix = [part](double from, double to) { return static_cast<int>(from + part * (to - from)); };
  return fmt::format("rgb({},{},{})", mix(253, 84), mix(231, 2), mix(150, 75));
}

// Where a loss lies between the least and the greatest one, by its logarithm where all are positive.
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
  const std::string inside = fmt::format(
      "<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' style='fill:{};stroke:#8888'/>"
      "<text x='{:.1f}' y='{:.1f}' text-anchor='middle' style='fill:{}'>{}</text>",
      x, y, width, height, known ? cell_colour(part) : "none", x + width / 2, y + height / 2 + 4,
      !known       ? "var(--text,#333)"
      : part > 0.5 ? "#fff"
                   : "#000",
      known ? fmt::format("{:.3g}", cell.value) : "-");
  return cell.href.empty() ? inside : fmt::format("<a href='{}'>{}</a>", escaped(cell.href), inside);
}

std::string cells_svg(const Figure& figure, double width, double height) {
  constexpr double kNames = 84;  // px left of the rows
  Axes axes;
  axes.x.begin = kNames, axes.x.end = width - kRight, axes.y.begin = height - kBottom,
  axes.y.end = Header(figure, width).bottom;
  const double across = (axes.x.end - axes.x.begin) / static_cast<double>(figure.columns.size()),
               down = (axes.y.begin - axes.y.end) / static_cast<double>(figure.rows.size());
  std::string svg = begin_svg(figure, width, height);
  const auto x = [&](std::size_t column) { return axes.x.begin + across * static_cast<double>(column); };
  const auto y = [&](std::size_t row) { return axes.y.begin - down * static_cast<double>(row + 1); };
  for (std::size_t i = 0; i < figure.columns.size(); ++i)
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}</text>", x(i) + across / 2,
                       axes.y.begin + 16, escaped(figure.columns[i]));
  for (std::size_t i = 0; i < figure.rows.size(); ++i)
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end'>{}</text>", kNames - 6,
                       y(i) + down / 2 + 4, escaped(figure.rows[i]));
  for (const Cell& cell : figure.cells) svg += draw(figure, cell, x(cell.column), y(cell.row), across, down);
  return svg + labels(figure, axes, width, height) + "</svg>\n";
}

}  // namespace

const char* role_name(Role role) {
  constexpr const char* kNames[] = {"truth", "plan", "estimate", "first", "second", "third"};
  return kNames[static_cast<int>(role)];
}

std::string to_svg(const Figure& figure, double width, double height) {
  if (!figure.boxes.empty()) return boxes_svg(figure, width, height);
  if (!figure.cells.empty()) return cells_svg(figure, width, height);
  const Axes axes = axes_of(figure, width, height);
  std::string svg = begin_svg(figure, width, height) + grid(axes);
  for (const Envelope& e : figure.envelopes) svg += draw(axes, e);
  for (const Level& level : figure.levels) svg += draw(axes, level);
  for (const Moment& moment : figure.moments) svg += draw(axes, moment);
  for (const Line& line : figure.lines) svg += draw(axes, line);
  return svg + frame(axes) + labels(figure, axes, width, height) + legend(figure, width) + "</svg>\n";
}

}  // namespace sim::pages
