// Statistics of lists of numbers, and quantities that may be absent. All functions take at least one value
// unless they state otherwise.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sim::score {

/// Why a quantity is absent.
struct Absent {
  std::string reason;
};
template <typename T>
using OrAbsent = std::variant<T, Absent>;

double mean(const std::vector<double>& values);
/// Root of the mean of the squares.
double root_mean_square(const std::vector<double>& values);
/// The middle value; of an even count the mean of the two in the middle.
double median(std::vector<double> values);
/// Of a sample (n − 1); 0 for a single value.
double standard_deviation(const std::vector<double>& values);
/// p in [0, 1]: linear between order statistics, p = 0 the minimum, p = 1 the maximum (Hyndman & Fan 1996,
/// type 7).
double quantile(std::vector<double> values, double p);

/// Which of several values of a metric is the worst.
enum class Worst { largest, smallest, largest_magnitude, farthest_from_expected };

/// The direction in which a metric becomes worse.
struct Direction {
  constexpr Direction(Worst which = Worst::largest) : worst(which) {}
  /// Away from a positive value that is expected, such as the degrees of freedom of a normalised square: as
  /// bad above it as below it, by the magnitude of the logarithm of their ratio.
  static constexpr Direction away_from(double expected_value) {
    Direction direction(Worst::farthest_from_expected);
    direction.expected = expected_value;
    return direction;
  }

  Worst worst;
  double expected = 1;  ///< for farthest_from_expected
};

/// A finite number that grows as the value becomes worse.
double loss(double value, const Direction& direction);

/// A metric over the seeds in which it is defined. Without any: n = 0 and the rest meaningless.
struct Summary {
  std::size_t n = 0;
  double median = 0, mean = 0, worst = 0;
  std::optional<double> standard_deviation{};  ///< of two and more
};
Summary summarize(const std::vector<double>& values, const Direction& direction);

}  // namespace sim::score
