// Statistics of lists of numbers (at least one unless stated otherwise), quantities that may be absent, and
// confidence intervals of the chi-square distribution.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace sim::score {

/// Why a quantity is absent.
struct Absent {
  std::string reason;
};
template <typename T>
using OrAbsent = std::variant<T, Absent>;

/// Returns function(the quantity), or why the quantity is absent.
template <typename T, typename F>
OrAbsent<double> value_of(const OrAbsent<T>& quantity, F function) {
  if (const auto* absent = std::get_if<Absent>(&quantity)) return *absent;
  return function(std::get<T>(quantity));
}

double mean(const std::vector<double>& values);
/// Returns the root of the mean of the squares.
double root_mean_square(const std::vector<double>& values);
/// Returns the middle value, or the mean of the two middle values for an even count.
double median(std::vector<double> values);
/// Returns the standard deviation of a sample (n − 1), or 0 for a single value.
double standard_deviation(const std::vector<double>& values);
/// Returns the quantile by linear interpolation; p = 0: minimum, 1: maximum (Hyndman & Fan 1996, type 7).
double quantile(std::vector<double> values, double p);

/// The worst of several values of a metric.
enum class Worst { largest, smallest, largest_magnitude, farthest_from_expected };

/// Which values of a metric are worse.
struct Direction {
  constexpr Direction(Worst which = Worst::largest) : worst(which) {}
  /// Returns a direction that is worse away from a positive expected value, such as the degrees of freedom of
  /// a normalized square. The magnitude of the logarithm of the ratio counts, so too large is as bad as too
  /// small.
  static constexpr Direction away_from(double expected_value) {
    Direction direction(Worst::farthest_from_expected);
    direction.expected = expected_value;
    return direction;
  }

  Worst worst;
  double expected = 1;  ///< for farthest_from_expected
};

/// Returns a finite number that grows as the value becomes worse.
double loss(double value, const Direction& direction);

/// A metric over the seeds that have a value. If there are none, n = 0 and the rest is meaningless.
struct Summary {
  std::size_t n = 0;
  double median = 0, mean = 0, worst = 0;
  std::optional<double> standard_deviation{};  ///< for two or more seeds
};
/// Returns the statistics of the values. The direction states which one is the worst.
Summary summarize(const std::vector<double>& values, const Direction& direction);

/// Returns the two-sided p-value of the signed rank test (Wilcoxon 1945) that paired, finite differences are
/// symmetric about 0; 1 if all are 0. Exact for up to 50 nonzero differences; for more, the normal
/// approximation.
double wilcoxon_signed_rank(const std::vector<double>& differences);

/// How far paired values are shifted. interval: absent for fewer than 6 values.
struct Shift {
  double estimate = 0;
  std::optional<std::pair<double, double>> interval{};
  double coverage = 0;  ///< of the interval, the least that is at least 0.95
};
/// Returns the median of the Walsh averages, which are the means of all pairs of differences (Hodges &
/// Lehmann 1963), and their interval. It excludes 0 exactly if the p-value of wilcoxon_signed_rank() is at
/// most 1 − coverage, unless differences are 0 or have equal magnitudes.
Shift hodges_lehmann(const std::vector<double>& differences);

/// Returns a confidence interval of at least 95 % for the median of the distribution from which the values
/// come, whatever it is (order statistics). Returns nothing for fewer than 6 values.
std::optional<std::pair<double, double>> median_interval(std::vector<double> values);

/// The 95 % confidence interval of a mean, and the two-sided p-value of the true mean being 0.
struct MeanTest {
  double low = 0, high = 0, p = 1;
};
/// Returns the t-test (Student 1908) of independent values, or nothing for fewer than 2.
std::optional<MeanTest> t_test(const std::vector<double>& values);

/// Returns the p-values adjusted for multiple tests (Holm 1979), in the same order, for comparison with the
/// level.
std::vector<double> holm(const std::vector<double>& p_values);

/// Returns the quantile for p in (0, 1) of a chi-square distribution with `dof` > 0 degrees of freedom.
double chi_square_quantile(double p, double dof);

/// The confidence interval of the mean of `count` independent normalized squares of `dof` degrees of freedom.
struct Band {
  double low = 0, high = 0;
};
/// Returns the band that contains the mean with the given probability (chi-square).
Band mean_band(int dof, int count, double confidence = 0.95);

inline constexpr double kSettled_s = 5;  ///< earlier moments are not judged, because the start is given

/// Consistency of many runs together. mean: over all moments. inside, below: the fractions of moments
/// when the mean over the runs is inside its 95 % confidence interval, or below it.
struct BandFractions {
  double mean = 0, inside = 0, below = 0;
};
/// Returns the fractions, or nothing if no run has a value. moments: for each moment, the normalized squares
/// (dof degrees of freedom) of the independent runs that have one.
std::optional<BandFractions> band_fractions(const std::vector<std::vector<double>>& moments, int dof);

}  // namespace sim::score
