// The verdicts on the gated metrics of one scenario: results compared with a baseline, seed by seed.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/result/score_file.h"

namespace sim::regression {

/// A metric to compare, and the tolerance by which it may become worse: the larger of `percent` of the
/// baseline's median and `absolute`, in the metric's unit. Of a metric with an expected value see
/// tolerated_factor().
struct Gate {
  std::string metric;
  double percent = 0, absolute = 0;
  bool operator==(const Gate&) const = default;
};

/// Of a metric with an expected value (score::Direction): the factor by which its ratio to that value may
/// become larger, or smaller, 1 + the larger of `percent` and of `absolute` in percent of the expected value.
/// Nothing for other metrics.
std::optional<double> tolerated_factor(const Gate& gate);

/// The largest number of gates of a scenario: the p-values are adjusted for their number (Holm 1979), and
/// with 8 seeds the least p-value, 2/2^8, stays below 0.05 after that.
inline constexpr std::size_t kMostGates = 6;
inline constexpr std::size_t kSeedsForTest = 8;

/// One scenario's runs. config: what shapes them, key to value (limits, name and seed left out).
struct ScenarioResults {
  std::string name;
  std::map<std::string, std::string> config;
  std::vector<result::SeedScore> seeds;

  /// The result of that seed, or nullptr.
  const result::SeedScore* find(std::uint64_t seed) const;
};

/// identical: the same bits on every seed · same: changed by no more than the tolerance · better, fail:
/// changed by more than the tolerance, and significantly · noisy: changed by more than the tolerance, but not
/// significantly · added: the baseline has no such value · missing: the baseline has values where there are
/// none now.
enum class Verdict { identical, same, better, fail, noisy, added, missing };
/// "IDENTICAL", ..., "NEW", "MISSING".
std::string_view word(Verdict verdict);
/// True for fail and missing.
bool fails(Verdict verdict);

/// One metric of one scenario: the baseline compared with the results now.
struct MetricVerdict {
  Gate gate{};
  std::size_t n = 0;                        ///< seeds compared; of unpaired sets the smaller number
  std::optional<double> baseline{}, now{};  ///< medians over them
  std::optional<double> change{};           ///< median of the seeds' changes; unpaired: of the medians
  std::optional<std::pair<double, double>>
      band{};                 ///< confidence interval of at least 95 % of the median change
  std::optional<double> p{};  ///< after Holm; absent without a test
  Verdict verdict = Verdict::same;
  std::string remark{};          ///< the reason in words; may be empty
  std::uint64_t worst_seed = 0;  ///< the seed that changed most for the worse
};

/// Judges each gate by the metric's loss (score::loss): on the seeds in common, by the signed rank test, or
/// else (paired = false) on all seeds, by the rank sum test. The p-values are adjusted for the number of
/// gates.
std::vector<MetricVerdict> judge_gates(const ScenarioResults& baseline, const ScenarioResults& now,
                                       const std::vector<Gate>& gates, bool paired);

/// The gates of a scenario that names none.
const std::vector<Gate>& default_gates();

}  // namespace sim::regression
