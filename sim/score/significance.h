// Whether a difference between two sets of runs is more than chance.
#pragma once

#include <optional>
#include <utility>
#include <vector>

namespace sim::score {

/// Two-sided p-value of the signed rank test (Wilcoxon 1945) that paired differences are symmetric about 0.
/// Zeros are left out; equal sizes share their mean rank. Exact for up to 50 differences, by the normal
/// approximation with corrections for ties and continuity beyond. 1 when nothing differs. All values finite.
double wilcoxon_signed_rank(const std::vector<double>& differences);

/// Two-sided p-value of the rank sum test (Wilcoxon 1945, Mann & Whitney 1947) that two sets of values, of
/// other seeds, come from the same distribution. Equal values share their mean rank. Exact (all ways of
/// dealing the ranks out) for up to 100 values in all, by the normal approximation with corrections for ties
/// and continuity beyond. 1 when one set is empty. All values finite.
double rank_sum(const std::vector<double>& a, const std::vector<double>& b);

/// Between which of the values the median lies that they are a sample of, with at least 95 % confidence
/// whatever their distribution (order statistics); nothing for fewer than 6.
std::optional<std::pair<double, double>> median_interval(std::vector<double> values);

/// p-values adjusted for being several (Holm 1979), in the order given: each may be compared with the level
/// itself.
std::vector<double> holm(const std::vector<double>& p_values);

/// Where the rate lies of which `successes` of `n` > 0 trials succeeded, with this confidence (Wilson 1927).
struct RateInterval {
  double low = 0, high = 1;
};
RateInterval wilson_interval(int successes, int n, double confidence = 0.95);

}  // namespace sim::score
