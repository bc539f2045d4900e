#include "sim/score/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace sim::score {

double mean(const std::vector<double>& values) {
  assert(!values.empty());
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double root_mean_square(const std::vector<double>& values) {
  assert(!values.empty());
  const double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

double standard_deviation(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  const double m = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - m) * (value - m);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double quantile(std::vector<double> values, double p) {
  assert(!values.empty() && p >= 0 && p <= 1);
  std::sort(values.begin(), values.end());
  const double place = p * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double part = place - static_cast<double>(below);
  return (1 - part) * values[below] + part * values[above];
}

double loss(double value, const Direction& direction) {
  switch (direction.worst) {
    case Worst::largest:
      return value;
    case Worst::smallest:
      return -value;
    case Worst::largest_magnitude:
      return std::abs(value);
    case Worst::farthest_from_expected:
      return std::abs(std::log(std::max(value, std::numeric_limits<double>::min()) / direction.expected));
  }
  return value;
}

Summary summarize(const std::vector<double>& values, const Direction& direction) {
  if (values.empty()) return {};
  const auto [minimum, maximum] = std::minmax_element(values.begin(), values.end());
  Summary summary{values.size(), median(values), mean(values),
                  loss(*minimum, direction) > loss(*maximum, direction) ? *minimum : *maximum};
  if (values.size() > 1) summary.standard_deviation = standard_deviation(values);
  return summary;
}

}  // namespace sim::score
