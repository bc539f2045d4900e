// A figure as data: what a report's page draws with a cursor, and what a file holds as a still picture.
#pragma once

#include <string>
#include <vector>

namespace sim::report {

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

/// name: of its file. x_label, y_label: with units. equal_axes: a metre is as long in x as in y.
struct Figure {
  std::string name, title, x_label, y_label;
  std::vector<Line> lines{};
  std::vector<Envelope> envelopes{};
  std::vector<Level> levels{};
  std::vector<Moment> moments{};
  bool equal_axes = false;
  bool logarithmic = false;    ///< y
  bool logarithmic_x = false;  ///< of still pictures
};

/// The figure as a complete SVG document of the given size (px). Colours are style classes with defaults, so
/// that a page may set its own.
std::string to_svg(const Figure& figure, double width, double height);

}  // namespace sim::report
