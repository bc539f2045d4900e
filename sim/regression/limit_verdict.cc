#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "sim/regression/verdict.h"
#include "sim/result/limits.h"
#include "sim/scenario/limits.h"

namespace sim::regression {
namespace {

LimitVerdict endings(const scenario::Scenario& scenario, const std::vector<result::SeedScore>& seeds) {
  LimitVerdict verdict;
  verdict.what = fmt::format("ending {}", fmt::join(scenario.limits.ending, " or "));
  for (const result::SeedScore& seed : seeds) {
    if (result::is_allowed(scenario, seed.ending)) continue;
    if (verdict.passed) verdict.worst_seed = seed.seed;
    verdict.passed = false;
    verdict.run_failed = true;
    verdict.failures.push_back(ending_text(seed) +
                               (seed.last_lines.empty() ? "" : "\nits last lines:\n" + seed.last_lines));
  }
  verdict.observed = fmt::format("{}/{}", seeds.size() - verdict.failures.size(), seeds.size());
  return verdict;
}

// The verdict on a limit, with the seed that has the worst value; a missing value is worse than any.
LimitVerdict verdict_on(const scenario::MetricLimit& limit, const std::string& observed, bool passed,
                        const std::vector<result::SeedScore>& seeds) {
  const auto loss = [&](const result::SeedScore& seed) {
    const auto value = seed.value(limit.metric);
    return value ? score::loss(*value, result::worst_side(limit)) : std::numeric_limits<double>::max();
  };
  const auto worst = std::max_element(seeds.begin(), seeds.end(),
                                      [&](const auto& a, const auto& b) { return loss(a) < loss(b); });
  return {.what = fmt::format("{} {} {}", subject(limit),
                              limit.bound == scenario::Bound::at_most ? "<=" : ">=", limit.value),
          .observed = observed,
          .passed = passed,
          .worst_seed = passed || seeds.empty() ? 0 : worst->seed};
}

LimitVerdict missed_by_all(const scenario::Scenario& scenario, const std::vector<result::SeedScore>& seeds) {
  LimitVerdict verdict;
  verdict.what = "misses a limit";
  std::size_t missed = 0;
  for (const result::SeedScore& seed : seeds) {
    const auto judged =
        result::judge_run(scenario, [&](const std::string& metric) { return seed.value(metric); });
    if (std::any_of(judged.begin(), judged.end(), [](const auto& limit) { return limit.missed(); }))
      ++missed;
    else if (std::exchange(verdict.passed, false))
      verdict.worst_seed = seed.seed;
  }
  verdict.observed = fmt::format("{}/{}", missed, seeds.size());
  return verdict;
}

}  // namespace

std::string_view word(const LimitVerdict& verdict) {
  return verdict.run_failed ? "RUN FAILED" : result::verdict_word(verdict.passed);
}

std::vector<LimitVerdict> judge_limits(const scenario::Scenario& scenario,
                                       const std::vector<result::SeedScore>& seeds, bool expects_missed) {
  std::vector<LimitVerdict> all{endings(scenario, seeds)};
  if (expects_missed) {
    all.push_back(missed_by_all(scenario, seeds));
    return all;
  }
  for (const scenario::MetricLimit& limit : scenario.limits.metrics) {
    if (!limit.aggregate.empty()) continue;
    std::size_t judged = 0, met = 0;
    for (const result::SeedScore& seed : seeds) {
      const auto passed = result::judge(scenario, limit, seed.value(limit.metric)).passed;
      judged += passed.has_value();
      met += passed.value_or(false);
    }
    if (judged > 0 || scenario.slam)
      all.push_back(verdict_on(limit, fmt::format("{}/{}", met, judged), met == judged, seeds));
  }
  for (const result::JudgedLimit& judged : result::summarize(scenario, seeds).limits) {
    const std::string reason = judged.reason.empty() ? "no value" : judged.reason;
    all.push_back(verdict_on(judged.limit, judged.value ? fmt::format("{:.4g}", *judged.value) : reason,
                             !judged.missed(), seeds));
  }
  return all;
}

}  // namespace sim::regression
