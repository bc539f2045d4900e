#include "sim/score/significance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/score/consistency.h"

namespace sim::score {
namespace {

constexpr std::size_t kExact = 50;  // 2^50 sign patterns are counted exactly in doubles

struct Ranked {
  std::vector<int> twice_rank;  // of |difference|; twice, so that shared ranks are whole numbers
  int twice_positive = 0;       // sum over the differences above 0
  double ties = 0;              // sum of t³ − t over groups of t equals
};

Ranked rank(std::vector<double> differences) {
  std::erase(differences, 0.0);
  std::sort(differences.begin(), differences.end(),
            [](double a, double b) { return std::abs(a) < std::abs(b); });
  Ranked ranked;
  for (std::size_t begin = 0, end; begin < differences.size(); begin = end) {
    end = begin;
    while (end < differences.size() && std::abs(differences[end]) == std::abs(differences[begin])) ++end;
    const double t = static_cast<double>(end - begin);
    ranked.ties += t * t * t - t;
    for (std::size_t i = begin; i < end; ++i) {
      ranked.twice_rank.push_back(static_cast<int>(begin + 1 + end));
      if (differences[i] > 0) ranked.twice_positive += ranked.twice_rank.back();
    }
  }
  return ranked;
}

// Of all sign patterns, the part whose sum of positive ranks is at most / at least what was seen: twice the
// smaller.
double exact_p(const Ranked& ranked) {
  const int total = std::accumulate(ranked.twice_rank.begin(), ranked.twice_rank.end(), 0);
  std::vector<double> patterns(static_cast<std::size_t>(total) + 1);
  patterns[0] = 1;
  for (const int r : ranked.twice_rank)
    for (std::size_t sum = patterns.size(); sum-- > static_cast<std::size_t>(r);)
      patterns[sum] += patterns[sum - static_cast<std::size_t>(r)];
  const auto seen = patterns.begin() + ranked.twice_positive;
  const double below = std::accumulate(patterns.begin(), seen + 1, 0.0),
               above = std::accumulate(seen, patterns.end(), 0.0);
  return std::min(1.0,
                  2 * std::min(below, above) / std::ldexp(1.0, static_cast<int>(ranked.twice_rank.size())));
}

double approximate_p(const Ranked& ranked) {
  const double n = static_cast<double>(ranked.twice_rank.size());
  const double mean = n * (n + 1) / 4, variance = n * (n + 1) * (2 * n + 1) / 24 - ranked.ties / 48;
  const double off = std::max(0.0, std::abs(ranked.twice_positive / 2.0 - mean) - 0.5);
  return std::erfc(off / std::sqrt(2 * variance));
}

// Ranks of two sets taken together.
struct Pooled {
  std::vector<int> twice_rank;  // of all; twice, so that shared ranks are whole numbers
  int twice_sum = 0;            // of the first set's
  double ties = 0;              // sum of t³ − t over groups of t equals
};

Pooled pool(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<std::pair<double, bool>> all;  // value, of the first set
  for (const double value : a) all.emplace_back(value, true);
  for (const double value : b) all.emplace_back(value, false);
  std::sort(all.begin(), all.end());
  Pooled pooled;
  for (std::size_t begin = 0, end; begin < all.size(); begin = end) {
    end = begin;
    while (end < all.size() && all[end].first == all[begin].first) ++end;
    const double t = static_cast<double>(end - begin);
    pooled.ties += t * t * t - t;
    for (std::size_t i = begin; i < end; ++i) {
      pooled.twice_rank.push_back(static_cast<int>(begin + 1 + end));
      if (all[i].second) pooled.twice_sum += pooled.twice_rank.back();
    }
  }
  return pooled;
}

// Of all ways to choose `count` of the ranks, the part whose sum is at most / at least what was seen: twice
// the smaller.
double exact_p(const Pooled& pooled, std::size_t count) {
  const auto total =
      static_cast<std::size_t>(std::accumulate(pooled.twice_rank.begin(), pooled.twice_rank.end(), 0));
  std::vector<std::vector<double>> ways(count + 1, std::vector<double>(total + 1));
  ways[0][0] = 1;
  for (const int r : pooled.twice_rank)
    for (std::size_t chosen = count; chosen > 0; --chosen)
      for (std::size_t sum = total + 1; sum-- > static_cast<std::size_t>(r);)
        ways[chosen][sum] += ways[chosen - 1][sum - static_cast<std::size_t>(r)];
  const auto& sums = ways[count];
  const auto seen = sums.begin() + pooled.twice_sum;
  const double below = std::accumulate(sums.begin(), seen + 1, 0.0),
               above = std::accumulate(seen, sums.end(), 0.0),
               all = std::accumulate(sums.begin(), sums.end(), 0.0);
  return std::min(1.0, 2 * std::min(below, above) / all);
}

double approximate_p(const Pooled& pooled, double m, double n) {
  const double N = m + n, mean = m * (N + 1) / 2;
  const double variance = m * n / 12 * (N + 1 - pooled.ties / (N * (N - 1)));
  if (variance <= 0) return 1;  // all are equal
  const double off = std::max(0.0, std::abs(pooled.twice_sum / 2.0 - mean) - 0.5);
  return std::erfc(off / std::sqrt(2 * variance));
}

}  // namespace

double rank_sum(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr std::size_t kExactInAll = 100;
  if (a.empty() || b.empty()) return 1;
  const Pooled pooled = pool(a, b);
  return pooled.twice_rank.size() <= kExactInAll
             ? exact_p(pooled, a.size())
             : approximate_p(pooled, static_cast<double>(a.size()), static_cast<double>(b.size()));
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
  const Ranked ranked = rank(differences);
  if (ranked.twice_rank.empty()) return 1;
  return ranked.twice_rank.size() <= kExact ? exact_p(ranked) : approximate_p(ranked);
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

RateInterval wilson_interval(int successes, int n, double confidence) {
  const double z2 = chi_square_quantile(confidence, 1), rate = static_cast<double>(successes) / n;
  const double middle = rate + z2 / (2 * n), half = std::sqrt(z2 * (rate * (1 - rate) + z2 / (4.0 * n)) / n);
  return {std::max(0.0, (middle - half) / (1 + z2 / n)), std::min(1.0, (middle + half) / (1 + z2 / n))};
}

}  // namespace sim::score
