// Compares a scenario's results with a baseline: a verdict on each gated metric and each limit. Verdicts are
// given as a table for the terminal and as JUnit XML, Markdown, JSON and GitHub annotations.
#pragma once

#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "sim/regression/suite.h"
#include "sim/score/statistics.h"

namespace sim::regression {

/// Returns the largest factor by which the ratio of a metric to its expected value (score::Direction) may
/// grow or shrink: 1 + the larger of `percent` and `absolute` in percent of the expected value. Returns
/// nothing for other metrics.
std::optional<double> tolerated_factor(const Gate& gate);

inline constexpr std::size_t kSeedsForTest = 8;  ///< needed for the signed rank test

/// identical: the same bits on every seed · same: changed by at most the tolerance · better, fail: changed by
/// more than the tolerance, and significantly · undecided: changed by more than the tolerance, but possibly
/// by chance · added: missing in the baseline · missing: only in the baseline.
enum class Verdict { identical, same, better, fail, undecided, added, missing };
/// Returns "IDENTICAL", ..., "NEW", "MISSING".
std::string_view word(Verdict verdict);

/// One metric of one scenario: the baseline compared with the current results.
struct MetricVerdict {
  Gate gate{};
  std::size_t n = 0;  ///< seeds compared
  /// Medians over them, or means if a value is expected. Magnitudes if a larger magnitude is worse.
  std::optional<double> baseline{}, now{};
  /// score::hodges_lehmann() of the seeds' changes; the mean, without interval, if a value is expected.
  std::optional<double> change{};
  std::optional<std::pair<double, double>> band{};  ///< interval of the change
  double coverage = 0;                              ///< of the interval, at least 0.95
  std::optional<double> p{};                        ///< after Holm's adjustment; absent without a test
  Verdict verdict = Verdict::missing;
  std::string remark{};                       ///< the reason in words; may be empty
  std::optional<std::uint64_t> worst_seed{};  ///< the seed that got worse the most, or lost its value
};

/// undecided: the mean over seeds violates the limit, but its 95 % confidence interval does not.
enum class LimitState { met, missed, undecided, run_failed };
/// Returns "ok", "MISSED", "UNDECIDED" or "RUN FAILED".
std::string word(LimitState state);

/// A limit of the scenario on each seed, or on a value over all seeds.
struct LimitVerdict {
  std::string what;      ///< "ate_se3_rmse_m <= 0.1", "loop_closed.mean >= 1", "ending completed"
  std::string observed;  ///< "9/10": seeds that meet the limit; or the value over seeds
  LimitState state = LimitState::missed;
  std::optional<std::uint64_t> worst_seed{};  ///< absent if the limit is met
  std::vector<std::string> failures{};  ///< for each failed run: "seed 4 fell: CAUSE", then its last lines
};

struct ScenarioVerdict {
  std::string name;
  std::size_t n_baseline = 0, n_now = 0;  ///< seeds compared, the same number if both sides have any
  std::size_t other_recordings = 0;       ///< number of pairs with different recordings
  std::vector<std::string> other_config;  ///< "key: baseline value -> current value"
  std::vector<MetricVerdict> metrics;
  std::vector<LimitVerdict> limits;
  /// The mean fraction of true poses with an estimate, of the baseline and now; absent if unknown.
  std::optional<std::pair<double, double>> coverage{};
  double wall_s = 0;   ///< wall time of the current runs; 0 if unknown
  std::string file{};  ///< the scenario's file
  /// Returns the command that repeats the run of a seed; may be empty.
  std::function<std::string(std::uint64_t seed)> repro{};
  std::string remedy{};  ///< the command that decides undecided rows; may be empty
};

/// Returns "key: baseline value -> current value" for each key that differs.
std::vector<std::string> config_differences(const std::map<std::string, std::string>& baseline,
                                            const std::map<std::string, std::string>& now);

/// Returns a verdict on each gate by the metric's loss (score::loss) on the common seeds, without limits. If
/// there are no common seeds, every gate is added, or missing if nothing was run. Gates without any value are
/// left out.
ScenarioVerdict compare(const ScenarioResults& baseline, const ScenarioResults& now,
                        const std::vector<Gate>& gates);

/// Returns verdicts on the allowed endings, on the limits for each seed (for a metric with an expected value:
/// on the mean), and on limits over seeds. Leaves out a limit that has no value on any seed if the scenario
/// has no filter. expects_missed: instead, every seed must miss a limit on single seeds, as for an estimator
/// too simple for the scenario.
std::vector<LimitVerdict> judge_limits(const scenario::Scenario& scenario,
                                       const std::vector<result::SeedScore>& seeds,
                                       bool expects_missed = false);

/// Returns verdicts on the means over seeds of NEES and of each sensor's NIS: whether they are in the 95 %
/// range of a consistent filter over as many seeds, widened as for noises that are assumed `factor` times too
/// large or too small. NEES: 10,000 draws of runs whose error is a random walk. NIS: the chi-square
/// distribution of white innovations, one each frame.
std::vector<LimitVerdict> judge_consistency(const std::vector<result::SeedScore>& seeds, double factor);

struct Comparison {
  std::string title;
  std::vector<ScenarioVerdict> scenarios;
  bool allow_undecided = false;  ///< undecided rows pass
};

/// Returns 0 if all rows passed, 1 if a metric or limit failed (or is undecided and that is not allowed), and
/// 3 if a run ended in a way that its scenario does not allow.
int exit_code(const Comparison& comparison);

/// Returns a table of 80 columns. The command that repeats a run appears once for all its rows. colors: color
/// the verdicts for a terminal.
std::string verdict_table(const Comparison& comparison, bool colors);
/// Returns JUnit XML with a testcase for each row: an error for failed runs, a failure for other rows that do
/// not pass, skipped for NEW and for undecided rows that are allowed. The first row of a scenario has the
/// wall time of its runs.
std::string junit(const Comparison& comparison);
/// Returns Markdown tables for a pull request.
std::string markdown(const Comparison& comparison);
/// Returns a line `::error file=...,title=...::...` for each row that does not pass, or `::warning` if the
/// row is undecided and that is allowed.
std::string github_annotations(const Comparison& comparison);
/// Returns all verdicts with their numbers as JSON.
std::string verdicts_json(const Comparison& comparison);

}  // namespace sim::regression
