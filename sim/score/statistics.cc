#include "sim/score/statistics.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace sim::score {
namespace {

// Otherwise each function is also compiled for long double.
using InDouble = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
constexpr std::size_t kExact = 50;  // 2^50 sign patterns have exact probabilities in doubles

// Twice the ranks of the absolute differences, so that shared ranks are whole numbers.
struct Ranks {
  std::vector<int> twice;
  int twice_positive = 0;  // sum over the positive differences
  double ties = 0;         // sum of t³ − t over groups of t equal values
};

// sizes: each with a flag that is set if its difference is positive.
Ranks rank(std::vector<std::pair<double, bool>> sizes) {
  std::ranges::sort(sizes);
  Ranks ranks;
  for (std::size_t begin = 0, end; begin < sizes.size(); begin = end) {
    end = begin;
    while (end < sizes.size() && sizes[end].first == sizes[begin].first) ++end;
    const double t = double(end - begin);
    ranks.ties += t * t * t - t;
    for (std::size_t i = begin; i < end; ++i) {
      ranks.twice.push_back(int(begin + 1 + end));
      if (sizes[i].second) ranks.twice_positive += ranks.twice.back();
    }
  }
  return ranks;
}

// The probability of each sum of ranks with a positive sign, if each sign is positive in half of the cases.
std::vector<double> sum_probabilities(const std::vector<int>& ranks) {
  std::vector<double> p(std::size_t(std::accumulate(ranks.begin(), ranks.end(), 0)) + 1);
  p[0] = 1;
  for (const int rank : ranks) {
    const auto r = std::size_t(rank);
    for (std::size_t sum = p.size(); sum-- > 0;) p[sum] = (p[sum] + (sum < r ? 0 : p[sum - r])) / 2;
  }
  return p;
}

// Twice the smaller of two probabilities: of a rank sum up to the observed one, and from it.
double exact_p(const Ranks& ranks) {
  const std::vector<double> p = sum_probabilities(ranks.twice);
  const auto observed = p.begin() + ranks.twice_positive;
  return std::min(1.0, 2 * std::min(std::accumulate(p.begin(), observed + 1, 0.0),
                                    std::accumulate(observed, p.end(), 0.0)));
}

// The normal approximation, corrected for ties and continuity.
double approximate_p(const Ranks& ranks) {
  const double n = double(ranks.twice.size()), mean = n * (n + 1) / 4,
               variance = n * (n + 1) * (2 * n + 1) / 24 - ranks.ties / 48;
  const double off = std::max(0.0, std::abs(ranks.twice_positive / 2.0 - mean) - 0.5);
  return std::erfc(off / std::sqrt(2 * variance));
}

}  // namespace

double mean(const std::vector<double>& values) {
  assert(!values.empty());
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

double root_mean_square(const std::vector<double>& values) {
  assert(!values.empty());
  const double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return std::sqrt(sum / double(values.size()));
}

double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

double standard_deviation(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  const double m = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - m) * (value - m);
  return std::sqrt(sum / double(values.size() - 1));
}

double quantile(std::vector<double> values, double p) {
  assert(!values.empty() && p >= 0 && p <= 1);
  std::ranges::sort(values);
  const double place = p * double(values.size() - 1);
  const auto below = std::size_t(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double part = place - double(below);
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
  const auto [minimum, maximum] = std::ranges::minmax_element(values);
  Summary summary{values.size(), median(values), mean(values),
                  loss(*minimum, direction) > loss(*maximum, direction) ? *minimum : *maximum};
  if (values.size() > 1) summary.standard_deviation = standard_deviation(values);
  return summary;
}

std::optional<std::pair<double, double>> median_interval(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t n = values.size();
  double tail = std::ldexp(1.0, -int(n)), term = tail;  // P(at most k of n fair coins), k = 0
  if (2 * tail > 0.05) return std::nullopt;
  std::size_t k = 0;
  for (; 2 * tail <= 0.05; ++k) {
    term *= double(n - k) / double(k + 1);
    tail += term;
  }
  return std::pair(values[k - 1], values[n - k]);
}

double wilcoxon_signed_rank(const std::vector<double>& differences) {
  std::vector<std::pair<double, bool>> signed_sizes;
  for (const double difference : differences)
    if (difference != 0) signed_sizes.emplace_back(std::abs(difference), difference > 0);
  if (signed_sizes.empty()) return 1;
  const Ranks ranks = rank(signed_sizes);
  return signed_sizes.size() <= kExact ? exact_p(ranks) : approximate_p(ranks);
}

Shift hodges_lehmann(const std::vector<double>& differences) {
  std::vector<double> averages;
  for (std::size_t i = 0; i < differences.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j) averages.push_back((differences[i] + differences[j]) / 2);
  std::ranges::sort(averages);
  std::vector<int> ranks(differences.size());
  std::iota(ranks.begin(), ranks.end(), 1);
  const std::vector<double> p = sum_probabilities(ranks);
  Shift shift{median(averages)};
  double tail = 0;
  for (std::size_t k = 1; 2 * (tail + p[k - 1]) <= 0.05; ++k) {
    tail += p[k - 1];
    shift.interval = std::pair(averages[k - 1], averages[averages.size() - k]);
    shift.coverage = 1 - 2 * tail;
  }
  return shift;
}

std::optional<MeanTest> t_test(const std::vector<double>& values) {
  if (values.size() < 2) return std::nullopt;
  const double n = double(values.size()), middle = mean(values),
               error = standard_deviation(values) / std::sqrt(n);
  if (error == 0) return MeanTest{middle, middle, middle == 0 ? 1.0 : 0.0};
  const boost::math::students_t_distribution<double, InDouble> t(n - 1);
  const double reach = error * quantile(complement(t, 0.025));
  return MeanTest{middle - reach, middle + reach, 2 * cdf(complement(t, std::abs(middle) / error))};
}

std::vector<double> holm(const std::vector<double>& p_values) {
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t i) { return p_values[i]; });
  std::vector<double> adjusted(p_values.size());
  double largest = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    largest = std::max(largest, std::min(1.0, double(order.size() - i) * p_values[order[i]]));
    adjusted[order[i]] = largest;
  }
  return adjusted;
}

double chi_square_quantile(double p, double dof) {
  return boost::math::quantile(boost::math::chi_squared_distribution<double, InDouble>(dof), p);
}

Band mean_band(int dof, int count, double confidence) {
  const double all = double(dof) * count, tail = (1 - confidence) / 2;
  return {chi_square_quantile(tail, all) / count, chi_square_quantile(1 - tail, all) / count};
}

std::optional<BandFractions> band_fractions(const std::vector<std::vector<double>>& moments, int dof) {
  std::vector<double> means;
  double inside = 0, below = 0;
  for (const std::vector<double>& squares : moments) {
    if (squares.empty()) continue;
    const Band band = mean_band(dof, int(squares.size()));
    means.push_back(mean(squares));
    below += means.back() < band.low;
    inside += means.back() >= band.low && means.back() <= band.high;
  }
  if (means.empty()) return std::nullopt;
  const auto count = double(means.size());
  return BandFractions{mean(means), inside / count, below / count};
}

}  // namespace sim::score
