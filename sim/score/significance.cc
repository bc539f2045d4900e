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

}  // namespace

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
