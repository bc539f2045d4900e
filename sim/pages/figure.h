// A figure as data, and its drawing as SVG: the one plot engine of pages, pictures and the view.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace sim::pages {

/// Selects the color: style sheets and pictures give each role its own.
enum class Role { truth, plan, estimate, first, second, third };
/// The name of a role in style sheets.
const char* role_name(Role role);

/// A line through points; a NaN breaks it.
struct Line {
  std::string name;
  Role role = Role::first;
  std::vector<double> x{}, y{};
  bool dots = false;  ///< draws the points only
};

/// The area between two lines over the same x, such as a 3-sigma envelope.
struct Envelope {
  std::string name;
  Role role = Role::first;
  std::vector<double> x{}, low{}, high{};
};

/// A horizontal line, such as the edge of a confidence band.
struct Level {
  std::string name;
  double y = 0;
};

/// A vertical line, such as the time of the loop closure.
struct Moment {
  std::string name;
  double x = 0;
};

/// Quartiles of some values, with the values as dots beside them: one box of a row.
struct Box {
  std::string name;
  Role role = Role::first;
  std::vector<double> values{};
};

/// A cell of a heat map: column and row from 0. A larger loss is drawn darker. href: link target, or empty.
struct Cell {
  std::size_t column = 0, row = 0;
  double value = 0, loss = 0;
  std::string href{};
};

/// name: used for its file. x_label, y_label: with units. A figure with boxes or cells has nothing else.
/// runs: the result folders shown, if there are several.
struct Figure {
  std::string name, title, x_label, y_label;
  std::vector<Line> lines{};
  std::vector<Envelope> envelopes{};
  std::vector<Level> levels{};
  std::vector<Moment> moments{};
  bool equal_axes = false;   ///< a meter has the same length along x and y
  bool logarithmic = false;  ///< y
  bool logarithmic_x = false;
  bool whole_x = false, whole_y = false;  ///< ticks are whole numbers
  std::vector<Box> boxes{};
  std::vector<Cell> cells{};
  std::vector<std::string> columns{}, rows{};  ///< names of a heat map's
  std::vector<std::string> runs{};

  bool is_over_time() const { return x_label.starts_with("time"); }
};

/// Maps values to pixels: low to `begin`, high to `end`, linearly or by the logarithm.
struct Axis {
  double low = 0, high = 1;
  double begin = 0, end = 1;
  bool logarithmic = false;
  bool whole = false;  ///< ticks are whole numbers

  double at(double value) const;
  /// Multiples of 1, 2 or 5 times a power of ten; on a logarithmic axis powers of ten if there are two.
  std::vector<double> ticks(int about) const;
};

/// The range of all finite values (positive ones on a logarithmic axis), widened by a margin; 0 to 1 if there
/// are none.
Axis axis_of(const std::vector<const std::vector<double>*>& values, bool logarithmic);

/// A tick's value in few digits; below 0.001 and from 100 000 on with a power of ten, as in 5·10⁻⁴.
std::string tick_text(double value);

/// An SVG document of the given size (px) with title and legend.
std::string to_svg(const Figure& figure, double width, double height);
/// The drawing only, for a page that has figure_style(), a caption and a legend. Its axes are attributes from
/// which web/figures.js reads values under the cursor.
std::string to_page_svg(const Figure& figure, double width, double height);
/// CSS of the drawings: plain colors, and those of the page if it defines them.
std::string figure_style();

}  // namespace sim::pages
