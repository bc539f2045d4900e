// An axis of a still picture: the range that holds the values, its ticks, and where a value lies.
#pragma once

#include <string>
#include <vector>

namespace sim::pages {

/// From value to picture: low at `begin`, high at `end` (px), linear or by the logarithm.
struct Axis {
  double low = 0, high = 1;
  double begin = 0, end = 1;
  bool logarithmic = false;
  bool whole = false;  ///< ticks are whole numbers

  double at(double value) const;
  std::vector<double> ticks(int about) const;  ///< multiples of 1, 2 or 5 times a power of ten; of a
                                               ///< logarithm powers of ten where there are two
};

/// The least range that holds all finite values (positive ones on a logarithmic axis), widened by a margin;
/// 0 to 1 if there are none.
Axis axis_of(const std::vector<const std::vector<double>*>& values, bool logarithmic);

/// A tick's value in few digits; below 0.001 and from 100 000 on by a power of ten, as in 5·10⁻⁴.
std::string tick_text(double value);

}  // namespace sim::pages
