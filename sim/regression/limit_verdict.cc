#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "sim/regression/verdict.h"
#include "sim/result/limits.h"
#include "sim/scenario/limits.h"

namespace sim::regression {
namespace {

LimitVerdict endings(const scenario::Scenario& scenario, const std::vector<result::SeedScore>& seeds) {
  const auto allowed = [&](const result::SeedScore& seed) {
    return result::is_allowed(scenario, seed.ending);
  };
  LimitVerdict verdict{
      .what = fmt::format("ending {}", fmt::join(scenario.limits.ending, " or ")),
      .observed = fmt::format("{}/{}", std::count_if(seeds.begin(), seeds.end(), allowed), seeds.size())};
  for (const result::SeedScore& seed : seeds) {
    if (allowed(seed)) continue;
    if (verdict.passed) verdict.worst_seed = seed.seed;
    verdict.passed = false;
    verdict.run_failed = true;
    verdict.failures.push_back(ending_text(seed) +
                               (seed.last_lines.empty() ? "" : "\nits last lines:\n" + seed.last_lines));
  }
  return verdict;
}

std::string text_of(const scenario::MetricLimit& limit) {
  return fmt::format("{} {} {}", subject(limit),
                     limit.bound == scenario::Bound::at_most ? "<=" : ">=", limit.value);
}

// The seed with the worst value; a missing value is worse than any.
std::uint64_t worst_seed(const scenario::MetricLimit& limit, const std::vector<result::SeedScore>& seeds) {
  const auto loss = [&](const result::SeedScore& seed) {
    const auto value = seed.value(limit.metric);
    return value ? score::loss(*value, result::worst_side(limit)) : std::numeric_limits<double>::max();
  };
  const auto better = [&](const auto& a, const auto& b) { return loss(a) < loss(b); };
  return seeds.empty() ? 0 : std::max_element(seeds.begin(), seeds.end(), better)->seed;
}

std::optional<LimitVerdict> on_each_seed(const scenario::Scenario& scenario,
                                         const scenario::MetricLimit& limit,
                                         const std::vector<result::SeedScore>& seeds) {
  std::size_t judged = 0, met = 0;
  for (const result::SeedScore& seed : seeds) {
    const auto passed = result::judge(scenario, limit, seed.value(limit.metric)).passed;
    judged += passed.has_value();
    met += passed.value_or(false);
  }
  if (judged == 0 && !scenario.slam) return std::nullopt;
  return LimitVerdict{.what = text_of(limit),
                      .observed = fmt::format("{}/{}", met, judged),
                      .passed = met == judged,
                      .worst_seed = met == judged ? 0 : worst_seed(limit, seeds)};
}

LimitVerdict over_seeds(const result::JudgedLimit& judged, const std::vector<result::SeedScore>& seeds) {
  return {.what = text_of(judged.limit),
          .observed = judged.value            ? fmt::format("{:.4g}", *judged.value)
                      : judged.reason.empty() ? "no value"
                                              : judged.reason,
          .passed = !judged.missed(),
          .worst_seed = worst_seed(judged.limit, seeds)};
}

}  // namespace

std::string_view word(const LimitVerdict& verdict) {
  return verdict.run_failed ? "RUN FAILED" : result::verdict_word(verdict.passed);
}

std::vector<LimitVerdict> judge_limits(const scenario::Scenario& scenario,
                                       const std::vector<result::SeedScore>& seeds) {
  std::vector<LimitVerdict> all{endings(scenario, seeds)};
  for (const scenario::MetricLimit& limit : scenario.limits.metrics)
    if (limit.aggregate.empty())
      if (const auto verdict = on_each_seed(scenario, limit, seeds)) all.push_back(*verdict);
  for (const result::JudgedLimit& judged : result::summarize(scenario, seeds).limits)
    all.push_back(over_seeds(judged, seeds));
  return all;
}

}  // namespace sim::regression
