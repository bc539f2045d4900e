// A figure as data: what a report's page draws with a cursor, and what a file holds as a still picture.
#pragma once

#include <string>
#include <vector>

namespace sim::pages {

/// Whose line it is; the style sheet and the still picture give each its own colour.
enum class Role { truth, plan, estimate, first, second, third };
/// The name of a role, as style sheets have it.
const char* role_name(Role role);

/// A line through points; not a number breaks it.
struct Line {
  std::string name;
  Role role = Role::first;
  std::vector<double> x{}, y{};
  bool dots = false;  ///< the points alone
};

/// What lies between two lines of the same x, as the 3-sigma envelope.
struct Envelope {
  std::string name;
  Role role = Role::first;
  std::vector<double> x{}, low{}, high{};
};

/// A horizontal line, as the edge of a confidence band.
struct Level {
  std::string name;
  double y = 0;
};

/// A vertical line, as the moment at which the loop closed.
struct Moment {
  std::string name;
  double x = 0;
};

/// The quartiles of some values, with the values themselves as dots: one box of a row of them.
struct Box {
  std::string name;
  Role role = Role::first;
  std::vector<double> values{};
};

/// A cell of a heat map: column and row from 0. loss: how bad the value is, which darkens the cell. href: what a
/// click opens; else empty.
struct Cell {
  std::size_t column = 0, row = 0;
  double value = 0, loss = 0;
  std::string href{};
};

/// name: of its file. x_label, y_label: with units. equal_axes: a metre is as long in x as in y. With boxes,
/// or with cells, there is nothing else in the figure. runs: the folders of the results that it shows, where
/// those are several.
struct Figure {
  std::string name, title, x_label, y_label;
  std::vector<Line> lines{};
  std::vector<Envelope> envelopes{};
  std::vector<Level> levels{};
  std::vector<Moment> moments{};
  bool equal_axes = false;
  bool logarithmic = false;    ///< y
  bool logarithmic_x = false;  ///< of still pictures
  bool whole_x = false;        ///< x is counted: its ticks are whole numbers, also y with whole_y
  bool whole_y = false;
  std::vector<Box> boxes{};
  std::vector<Cell> cells{};
  std::vector<std::string> columns{}, rows{};  ///< the names of a heat map's
  std::vector<std::string> runs{};

  /// Whether a page shows it as a still picture.
  bool is_still() const { return equal_axes || !boxes.empty() || !cells.empty(); }
};

/// The figure as a complete SVG document of the given size (px). Colours are style classes with defaults, so
/// that a page may set its own.
std::string to_svg(const Figure& figure, double width, double height);

}  // namespace sim::pages
