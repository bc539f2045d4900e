#include "sim/regression/verdict.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/files/text.h"
#include "sim/result/limits.h"
#include "sim/scenario/keys.h"
#include "sim/score/metrics.h"
#include "sim/score/statistics.h"

namespace sim::regression {
namespace {

constexpr double kLevel = 0.05;

// "seed 4 fell: CAUSE"
std::string ending_text(const result::SeedScore& seed) {
  return fmt::format("seed {} {}{}{}", seed.seed, scenario::name_of(seed.ending),
                     seed.cause.empty() ? "" : ": ", seed.cause);
}

// A metric's values on the seeds that both sides have.
struct Values {
  std::vector<std::uint64_t> seeds;
  std::vector<double> baseline, now;
  std::vector<double> changes, worse_by;  // by how much each seed and its loss increased
  std::vector<double> lost;               // values of the baseline that have gone
  std::size_t won = 0;                    // values that only the results have
  std::string why_lost;                   // how the first run without its value ended
  bool identical = true;
};

Values values_of(const ScenarioResults& baseline, const ScenarioResults& now, const std::string& metric) {
  const score::Direction direction = score::direction_of(metric);
  Values values;
  for (const result::SeedScore& seed : now.seeds) {
    const result::SeedScore* other = baseline.find(seed.seed);
    if (!other) continue;
    const auto a = other->value(metric), b = seed.value(metric);
    values.identical &= a == b;
    if (a && b) {
      values.seeds.push_back(seed.seed);
      values.baseline.push_back(*a);
      values.now.push_back(*b);
      values.changes.push_back(*b - *a);
      values.worse_by.push_back(score::loss(*b, direction) - score::loss(*a, direction));
    } else if (a) {
      if (values.lost.empty()) values.why_lost = ending_text(seed);
      values.lost.push_back(*a);
    } else {
      values.won += b.has_value();
    }
  }
  return values;
}

// The verdict for too few seeds for a test: by the number of seeds that changed by more than the tolerance.
Verdict by_seeds(const std::vector<double>& worse_by, double tolerance, std::string& remark) {
  const auto n = std::ssize(worse_by),
             worse = std::ranges::count_if(worse_by, [&](double d) { return d > tolerance; }),
             better = std::ranges::count_if(worse_by, [&](double d) { return d < -tolerance; });
  if (worse + better == 0) return Verdict::same;
  if (remark.empty())
    remark = fmt::format("{} of {} worse beyond tolerance, {} better", worse,
                         files::counted(worse_by.size(), "seed"), better);
  if (better == 0 && 2 * worse > n) return Verdict::fail;
  if (worse == 0 && 2 * better > n) return Verdict::better;
  return Verdict::noisy;
}

// By how much the loss may grow.
double tolerance(const Gate& gate, double baseline) {
  if (const auto factor = tolerated_factor(gate)) return std::log(*factor);
  return std::max(gate.absolute, gate.percent / 100 * std::abs(baseline));
}

// p: after Holm; absent without a test.
MetricVerdict judge(const Gate& gate, const Values& values, std::optional<double> p) {
  MetricVerdict v{.gate = gate, .n = values.now.size(), .p = p};
  if (values.won > 0)
    v.remark = fmt::format("{} got a value that had none before", files::counted(values.won, "seed"));
  if (v.n > 0) {
    v.baseline = score::median(values.baseline);
    v.now = score::median(values.now);
    v.change = score::median(values.changes);
    v.band = score::median_interval(values.changes);
    const auto worst = std::ranges::max_element(values.worse_by) - values.worse_by.begin();
    v.worst_seed = values.seeds[static_cast<std::size_t>(worst)];
    const double worse = score::median(values.worse_by), tolerated = tolerance(gate, *v.baseline);
    if (v.n < kSeedsForTest) {
      v.verdict = by_seeds(values.worse_by, tolerated, v.remark);
    } else if (p && std::abs(worse) > tolerated) {
      v.verdict = *p >= kLevel ? Verdict::noisy : worse > 0 ? Verdict::fail : Verdict::better;
      if (*p >= kLevel) v.remark = "not significant: more seeds are needed";
    }
  } else if (values.identical) {
    v.remark = "no run has a value";
  }
  if (values.identical) {
    v.verdict = Verdict::identical;
  } else if (!values.lost.empty()) {
    v.verdict = Verdict::missing;
    v.remark =
        fmt::format("{} lost the value: {}", files::counted(values.lost.size(), "seed"), values.why_lost);
    if (!v.baseline) v.baseline = score::median(values.lost);
  } else if (v.n == 0) {
    v.verdict = Verdict::added;
    v.remark.clear();
  }
  return v;
}

// Adds how far the medians are from the expected value, if there is one.
void add_distances(MetricVerdict& v) {
  using enum Verdict;
  const score::Direction direction = score::direction_of(v.gate.metric);
  const auto factor = [&](double value) { return std::exp(score::loss(value, direction)); };
  if (tolerated_factor(v.gate) && (v.verdict == better || v.verdict == fail || v.verdict == noisy))
    v.remark = fmt::format("{} expected, off by a factor of {:.3g} before, {:.3g} now{}", direction.expected,
                           factor(*v.baseline), factor(*v.now), v.remark.empty() ? "" : "; " + v.remark);
}

std::vector<MetricVerdict> judge_gates(const ScenarioResults& baseline, const ScenarioResults& now,
                                       const std::vector<Gate>& gates) {
  std::vector<Values> values;
  std::vector<std::optional<double>> tested;
  std::vector<double> p;
  for (const Gate& gate : gates) {
    const Values& v = values.emplace_back(values_of(baseline, now, gate.metric));
    const bool is_tested = v.now.size() >= kSeedsForTest && !v.identical && v.lost.empty();
    tested.push_back(is_tested ? std::optional(score::wilcoxon_signed_rank(v.worse_by)) : std::nullopt);
    p.push_back(tested.back().value_or(1));
  }
  p = score::holm(p);
  std::vector<MetricVerdict> verdicts;
  for (std::size_t i = 0; i < gates.size(); ++i)
    add_distances(
        verdicts.emplace_back(judge(gates[i], values[i], tested[i] ? std::optional(p[i]) : std::nullopt)));
  return verdicts;
}

// The verdict on gates of a scenario that only one side has.
std::vector<MetricVerdict> one_sided(const std::vector<result::SeedScore>& seeds,
                                     const std::vector<Gate>& gates, Verdict verdict) {
  std::vector<MetricVerdict> verdicts;
  for (const Gate& gate : gates) {
    MetricVerdict v{.gate = gate,
                    .verdict = verdict,
                    .remark = verdict == Verdict::missing ? "the scenario was not run" : ""};
    const std::vector<double> values = result::values_of(gate.metric, seeds);
    v.n = values.size();
    if (v.n > 0) (verdict == Verdict::added ? v.now : v.baseline) = score::median(values);
    verdicts.push_back(v);
  }
  return verdicts;
}

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
  const auto worst = std::ranges::max_element(seeds, {}, loss);
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
  for (const result::SeedScore& seed : seeds)
    if (std::ranges::any_of(result::judge_run(scenario, [&](const auto& m) { return seed.value(m); }),
                            &result::JudgedLimit::missed))
      ++missed;
    else if (std::exchange(verdict.passed, false))
      verdict.worst_seed = seed.seed;
  verdict.observed = fmt::format("{}/{}", missed, seeds.size());
  return verdict;
}

}  // namespace

std::optional<double> tolerated_factor(const Gate& gate) {
  const score::Direction direction = score::direction_of(gate.metric);
  if (direction.worst != score::Worst::farthest_from_expected) return std::nullopt;
  return 1 + std::max(gate.absolute / direction.expected, gate.percent / 100);
}

std::string_view word(Verdict verdict) {
  static constexpr std::array<std::string_view, 7> kWords{"IDENTICAL", "SAME", "BETTER", "FAIL",
                                                          "NOISY",     "NEW",  "MISSING"};
  return kWords[static_cast<std::size_t>(verdict)];
}

bool fails(Verdict verdict) { return verdict == Verdict::fail || verdict == Verdict::missing; }

std::vector<std::string> config_differences(const std::map<std::string, std::string>& baseline,
                                            const std::map<std::string, std::string>& now) {
  const auto text = [](const auto& config, const std::string& key) {
    const auto found = config.find(key);
    return found == config.end() ? std::string("not set") : found->second;
  };
  std::map<std::string, std::string> keys = baseline;
  keys.insert(now.begin(), now.end());
  std::vector<std::string> all;
  for (const auto& [key, value] : keys)
    if (text(baseline, key) != text(now, key))
      all.push_back(fmt::format("{}: {} -> {}", key, text(baseline, key), text(now, key)));
  return all;
}

ScenarioVerdict compare(const ScenarioResults& baseline, const ScenarioResults& now,
                        const std::vector<Gate>& gates) {
  ScenarioVerdict verdict;
  verdict.name = now.name;
  std::size_t common = 0;
  for (const result::SeedScore& seed : now.seeds) {
    const result::SeedScore* other = baseline.find(seed.seed);
    common += other != nullptr;
    verdict.other_recordings += other && other->recording != seed.recording;
    verdict.wall_s += seed.wall_s;
  }
  if (common > 0) {
    verdict.n_baseline = verdict.n_now = common;
    verdict.other_config = config_differences(baseline.config, now.config);
    verdict.metrics = judge_gates(baseline, now, gates);
  } else if (now.seeds.empty()) {
    verdict.n_baseline = baseline.seeds.size();
    verdict.metrics = one_sided(baseline.seeds, gates, Verdict::missing);
  } else {
    verdict.n_now = now.seeds.size();
    verdict.metrics = one_sided(now.seeds, gates, Verdict::added);
  }
  return verdict;
}

std::string word(const LimitVerdict& verdict) {
  return verdict.run_failed ? "RUN FAILED" : result::verdict_text(verdict.passed, false);
}

std::vector<LimitVerdict> judge_limits(const scenario::Scenario& scenario,
                                       const std::vector<result::SeedScore>& seeds, bool expects_missed) {
  std::vector<LimitVerdict> all{endings(scenario, seeds)};
  if (expects_missed) {
    all.push_back(missed_by_all(scenario, seeds));
    return all;
  }
  for (const scenario::MetricLimit& limit : scenario.limits.metrics) {
    if (limit.aggregate) continue;
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
    const std::string reason = judged.reason.value_or("no value");
    all.push_back(verdict_on(judged.limit, judged.value ? fmt::format("{:.4g}", *judged.value) : reason,
                             !judged.missed(), seeds));
  }
  return all;
}

int exit_code(const std::vector<ScenarioVerdict>& verdicts) {
  int worst = 0;
  for (const ScenarioVerdict& scenario : verdicts) {
    for (const MetricVerdict& m : scenario.metrics) worst = std::max(worst, fails(m.verdict) ? 1 : 0);
    for (const LimitVerdict& l : scenario.limits)
      worst = std::max(worst, l.passed ? 0 : l.run_failed ? 3 : 1);
  }
  return worst;
}

}  // namespace sim::regression
