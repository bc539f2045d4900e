// Whether a program does as well as it did: each metric that is watched, seed by seed, and what must be kept
// in any case.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/bench/summary.h"

namespace sim::bench {

/// A metric that is watched, and by how much it may become worse: the larger of `percent` of the baseline's
/// median and `absolute`, in the metric's unit.
struct Gate {
  std::string metric;
  double percent = 0, absolute = 0;
  bool operator==(const Gate&) const = default;
};

/// At most so many in a scenario: the p-values are adjusted for their number (Holm 1979), and with 8 seeds
/// the least p-value, 2/2^8, stays below 0.05 after that.
inline constexpr std::size_t kMostGates = 6;
inline constexpr std::size_t kSeedsForTest = 8;

/// One scenario's runs. config: what shapes them, key to value (limits, name and seed left out).
struct ScenarioResults {
  std::string name;
  std::map<std::string, std::string> config;
  std::vector<SeedScore> seeds;
};

/// identical: the same bits on every seed · same: changed by no more than the tolerance · better, fail:
/// beyond it, and more than chance · noisy: beyond it, yet it may be chance · added: the baseline has no such
/// value · missing: the baseline has values where there are none now.
enum class Verdict { identical, same, better, fail, noisy, added, missing };
/// "IDENTICAL", ..., "NEW", "MISSING".
std::string_view word(Verdict verdict);
/// fail and missing.
bool fails(Verdict verdict);

/// One metric of one scenario, baseline against now.
struct MetricVerdict {
  Gate gate{};
  std::size_t n = 0;                        ///< seeds compared; of unpaired sets the smaller number
  std::optional<double> baseline{}, now{};  ///< medians over them
  std::optional<double> change{};           ///< median of the seeds' changes; unpaired: of the medians
  std::optional<std::pair<double, double>>
      band{};                 ///< at least 95 % confidence that the median change is in it
  std::optional<double> p{};  ///< after Holm; absent where no test was made
  Verdict verdict = Verdict::same;
  std::string remark{};          ///< why, in a few words; may be empty
  std::uint64_t worst_seed = 0;  ///< that changed most for the worse
};

/// A limit over seeds or on each seed, and how many seeds keep it.
struct LimitVerdict {
  std::string what;  ///< "ate_se3_rmse_m <= 0.1", "loop_closed.mean >= 1", "ending completed"
  std::string kept;  ///< "10/10", or the value over seeds
  bool passed = true;
  bool run_failed = false;  ///< a run ended in a way that is not allowed
  std::uint64_t worst_seed = 0;
};

struct ScenarioVerdict {
  std::string name;
  bool paired = true;                     ///< the same seeds on both sides
  std::size_t n_baseline = 0, n_now = 0;  ///< seeds compared
  std::size_t other_recordings = 0;       ///< of the pairs, how many recordings differ
  std::vector<std::string> other_config;  ///< "key: baseline's -> now's"
  std::vector<MetricVerdict> metrics;
  std::vector<LimitVerdict> limits;
};

/// Compares the watched metrics. The seeds in common are paired (signed rank test); without any in common the
/// sets are compared as they are (rank sum test). Limits are left to judge_limits.
ScenarioVerdict compare(const ScenarioResults& baseline, const ScenarioResults& now,
                        const std::vector<Gate>& gates);

/// All of a scenario that the baseline (or now) does not have.
ScenarioVerdict without_counterpart(const ScenarioResults& there, const std::vector<Gate>& gates,
                                    Verdict verdict);

/// The scenario's limits on its runs.
std::vector<LimitVerdict> judge_limits(const Scenario& scenario, const std::vector<SeedScore>& seeds);

/// 0 all is well, 1 a metric or limit fails, 3 a run ended in a way that its scenario does not allow.
int exit_code(const std::vector<ScenarioVerdict>& verdicts);

/// The gates of a scenario that names none.
const std::vector<Gate>& default_gates();

}  // namespace sim::bench
