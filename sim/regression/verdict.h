// Results of a scenario compared with a baseline: a verdict on each gated metric and each limit.
#pragma once

#include <string>
#include <vector>

#include "sim/regression/limit_verdict.h"
#include "sim/regression/metric_verdict.h"

namespace sim::regression {

struct ScenarioVerdict {
  std::string name;
  bool paired = true;                     ///< the same seeds on both sides
  std::size_t n_baseline = 0, n_now = 0;  ///< seeds compared
  std::size_t other_recordings = 0;       ///< of the pairs, how many recordings differ
  std::vector<std::string> other_config;  ///< "key: baseline's -> now's"
  std::vector<MetricVerdict> metrics;
  std::vector<LimitVerdict> limits;
};

/// Compares the gated metrics. The seeds in common are paired (signed rank test); without any in common the
/// sets are compared as they are (rank sum test). Limits are left to judge_limits.
ScenarioVerdict compare(const ScenarioResults& baseline, const ScenarioResults& now,
                        const std::vector<Gate>& gates);

/// The verdict on a scenario that only one side has. verdict: added or missing.
ScenarioVerdict without_counterpart(const ScenarioResults& there, const std::vector<Gate>& gates,
                                    Verdict verdict);

/// 0 passed, 1 a metric or limit fails, 3 a run ended in a way that its scenario does not allow.
int exit_code(const std::vector<ScenarioVerdict>& verdicts);

}  // namespace sim::regression
