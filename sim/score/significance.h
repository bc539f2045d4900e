// Significance of a difference between two sets of runs.
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

/// Confidence interval of at least 95 % for the median of the distribution of which the values are a sample,
/// whatever that distribution is (order statistics); nothing for fewer than 6 values.
std::optional<std::pair<double, double>> median_interval(std::vector<double> values);

/// p-values adjusted for being several (Holm 1979), in the order given: each may be compared with the level
/// itself.
std::vector<double> holm(const std::vector<double>& p_values);

}  // namespace sim::score
