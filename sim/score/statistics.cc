#include "sim/score/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace sim::score {
namespace {

constexpr std::size_t kExact = 50;        // 2^50 sign patterns are counted exactly in doubles
constexpr std::size_t kExactInAll = 100;  // of the rank sum test

// Twice the ranks of values, some of them chosen: shared ranks become whole numbers.
struct Ranks {
  std::vector<int> twice;
  int twice_chosen = 0;  // sum over the chosen ones
  double ties = 0;       // sum of t³ − t over groups of t equals
};

// values: each with whether it is chosen.
Ranks rank(std::vector<std::pair<double, bool>> values) {
  std::sort(values.begin(), values.end());
  Ranks ranks;
  for (std::size_t begin = 0, end; begin < values.size(); begin = end) {
    end = begin;
    while (end < values.size() && values[end].first == values[begin].first) ++end;
    const double t = static_cast<double>(end - begin);
    ranks.ties += t * t * t - t;
    for (std::size_t i = begin; i < end; ++i) {
      ranks.twice.push_back(static_cast<int>(begin + 1 + end));
      if (values[i].second) ranks.twice_chosen += ranks.twice.back();
    }
  }
  return ranks;
}

// The two-sided p-value: twice the smaller of the probabilities that the sum of ranks is at most or at least
// the observed one. ways: the number of ways to reach each sum; all: their total.
double exact_p(const std::vector<double>& ways, int observed, double all) {
  const auto at = ways.begin() + observed;
  const double below = std::accumulate(ways.begin(), at + 1, 0.0),
               above = std::accumulate(at, ways.end(), 0.0);
  return std::min(1.0, 2 * std::min(below, above) / all);
}

std::size_t sum(const std::vector<int>& ranks) {
  return static_cast<std::size_t>(std::accumulate(ranks.begin(), ranks.end(), 0));
}

// Over all sign patterns.
double exact_signed_rank(const Ranks& ranks) {
  std::vector<double> patterns(sum(ranks.twice) + 1);
  patterns[0] = 1;
  for (const int r : ranks.twice)
    for (std::size_t total = patterns.size(); total-- > static_cast<std::size_t>(r);)
      patterns[total] += patterns[total - static_cast<std::size_t>(r)];
  return exact_p(patterns, ranks.twice_chosen, std::ldexp(1.0, static_cast<int>(ranks.twice.size())));
}

// Over all choices of `count` ranks.
double exact_rank_sum(const Ranks& ranks, std::size_t count) {
  const std::size_t most = sum(ranks.twice);
  std::vector<std::vector<double>> ways(count + 1, std::vector<double>(most + 1));
  ways[0][0] = 1;
  for (const int r : ranks.twice)
    for (std::size_t chosen = count; chosen > 0; --chosen)
      for (std::size_t total = most + 1; total-- > static_cast<std::size_t>(r);)
        ways[chosen][total] += ways[chosen - 1][total - static_cast<std::size_t>(r)];
  return exact_p(ways[count], ranks.twice_chosen,
                 std::accumulate(ways[count].begin(), ways[count].end(), 0.0));
}

// The normal approximation, with the correction for continuity.
double approximate_p(const Ranks& ranks, double mean, double variance) {
  if (variance <= 0) return 1;  // all values are equal
  const double off = std::max(0.0, std::abs(ranks.twice_chosen / 2.0 - mean) - 0.5);
  return std::erfc(off / std::sqrt(2 * variance));
}

double approximate_signed_rank(const Ranks& ranks) {
  const double n = static_cast<double>(ranks.twice.size());
  return approximate_p(ranks, n * (n + 1) / 4, n * (n + 1) * (2 * n + 1) / 24 - ranks.ties / 48);
}

double approximate_rank_sum(const Ranks& ranks, double m, double n) {
  const double N = m + n;
  return approximate_p(ranks, m * (N + 1) / 2, m * n / 12 * (N + 1 - ranks.ties / (N * (N - 1))));
}

}  // namespace

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

double rank_sum(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.empty() || b.empty()) return 1;
  std::vector<std::pair<double, bool>> pooled;
  for (const double value : a) pooled.emplace_back(value, true);
  for (const double value : b) pooled.emplace_back(value, false);
  const Ranks ranks = rank(pooled);
  return pooled.size() <= kExactInAll
             ? exact_rank_sum(ranks, a.size())
             : approximate_rank_sum(ranks, static_cast<double>(a.size()), static_cast<double>(b.size()));
}

std::optional<std::pair<double, double>> median_interval(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  double tail = std::ldexp(1.0, -static_cast<int>(n)), term = tail;  // P(at most k of n fair coins), k = 0
  if (2 * tail > 0.05) return std::nullopt;
  std::size_t k = 0;
  for (; 2 * tail <= 0.05; ++k) {
    term *= static_cast<double>(n - k) / static_cast<double>(k + 1);
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
  return signed_sizes.size() <= kExact ? exact_signed_rank(ranks) : approximate_signed_rank(ranks);
}

std::vector<double> holm(const std::vector<double>& p_values) {
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(p_values.size());
  double largest = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    largest = std::max(largest, std::min(1.0, static_cast<double>(order.size() - i) * p_values[order[i]]));
    adjusted[order[i]] = largest;
  }
  return adjusted;
}

}  // namespace sim::score
